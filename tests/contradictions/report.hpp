// What a kind of trouble did to many shots: silent wrong numbers, flags, coverage; in words, tables for
// people and JSON lines for programs. Plain values; one thread at a time.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/contradictions/judge.hpp"
#include "tests/contradictions/shot.hpp"

namespace strobe::contradictions {

/// Of one number over all shots that have it with an sd.
struct Coverage {
  std::int64_t count = 0, within_68 = 0, within_95 = 0;
  double square = 0.0;  ///< sum of z^2
};

struct WorstShot {
  std::uint64_t number = 0;
  double error_sd = 0.0;
};

struct Tally {
  std::int64_t shots = 0, refused = 0;
  std::int64_t silent = 0;      ///< shots with a silently wrong number
  std::int64_t unprovable = 0;  ///< likewise, of trouble that their data cannot prove; not counted above
  std::int64_t few = 0;         ///< of the others, shots with one that nothing but no_redundancy explains
  std::int64_t flagged = 0;     ///< of the others, shots with a wrong number
  std::int64_t slides_wrongly = 0, grips_wrongly = 0, gripped = 0, slid = 0;
  std::array<std::int64_t, reduction::kQuantityCount> silent_by_quantity{};
  std::array<std::int64_t, reduction::kFlagCount> flags{};
  std::array<Coverage, reduction::kQuantityCount> coverage{};
  std::vector<WorstShot> worst;  ///< at most three, the worst first
  std::vector<WorstShot> worst_unprovable;

  void add(const Shot& shot, std::uint64_t number);
  void merge(const Tally& other);

  double share(std::int64_t count) const {
    return shots > 0 ? static_cast<double>(count) / static_cast<double>(shots) : 0.0;
  }
};

/// Upper limit, at 95 % one-sided confidence, of the probability of which `count` of `of` came up (Wilson
/// 1927).
double upper_limit_95(std::int64_t count, std::int64_t of);

struct Run {
  Kind kind = Kind::none;
  Settings settings;
  std::uint64_t seed = 1;
  std::int64_t shots = 20000;
};

/// Shots 1 to run.shots.
Tally tallied(const Run& run);

struct Row {
  Run run;
  Tally tally;
};

std::string table(const std::vector<Row>& rows);
/// Each alarm's share on undisturbed shots.
std::string false_flags(const Row& undisturbed);
std::string coverage_table(const Row& row);
std::string json_line(const Row& row);
/// The frame with its truth beside it, on one line; `strobe reduce --format frame` reads it.
std::string shot_line(const Shot& shot);

}  // namespace strobe::contradictions
