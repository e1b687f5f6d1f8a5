// Balls that are dropped, photographed and read, held against the scenes that they are of: rendered photographs,
// the train that the plan for such a drop has, digitizer, assembly and reduction. Thread-safe; allocates.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/result.hpp"
#include "host/config/plan_file.hpp"

namespace strobe::studies::drops {

struct DropCase {
  int ball = 0, height = 0;  ///< of kBalls, kHeights_m
  int shot = 1;
};
inline constexpr int kBallCount = 3, kHeightCount = 5;
/// The i-th of the study: balls and heights in turn.
DropCase drop_case(int i);
std::string name_of(const DropCase& c);

struct DropOptions {
  std::uint64_t seed = 1;
  host::Spacing spacing = host::Spacing::coded;
  std::optional<double> period_ms{};  ///< instead of the plan's own
};

struct ReadDrop {
  std::string refused;  ///< why there is no plan for it; then nothing else
  double period_ms = 0.0;
  int images = 0;  ///< told of either leg
  /// Read less true, and the stated total standard uncertainty; absent: not read.
  std::optional<double> e_error, height_error_m;
  double e_sd = 0.0, height_sd_m = 0.0;
  bool flagged = false;  ///< with one that says that a number may be wrong
  std::string words;     ///< flags and what a person would be told
};

/// Fails as the renderer and the digitizer do.
Result<ReadDrop> read_drop(const DropCase& c, const DropOptions& options);

}  // namespace strobe::studies::drops
