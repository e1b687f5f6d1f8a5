// What a session's shots are to a protocol, what is left to fire, what is computed and decided.
// Deterministic; no I/O; thread-safe; allocates. Sources: JCGM 100:2008 (GUM), 5.1 and G.4; JCGM 106:2012, 7
// and 8.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/protocol/protocol.hpp"
#include "host/series/series.hpp"
#include "host/session/shot.hpp"

namespace strobe::protocol {

/// Notes of a shot that was fired for a protocol.
inline constexpr std::string_view kPositionNote = "protocol.position";
inline constexpr std::string_view kBallNote = "ball_name";  ///< "1", "2" ... unless the operator names balls
inline constexpr std::string_view kProtocolNote = "protocol.name";

struct Cell {
  std::string position, ball;
  bool operator==(const Cell&) const = default;
};

/// "position 2, ball 3"; empty of a cell without a position.
std::string words(const Cell& cell);

enum class Use {
  counts,
  discarded,       ///< conditioning
  not_conforming,  ///< to be replaced; `why` names the quantity
  rejected,        ///< no readout
  surplus,         ///< of a cell that is full, or of none
};

struct UsedShot {
  std::string shot;  ///< host::Shot::full_name()
  Cell cell;
  Use use = Use::counts;
  std::string why;
};

/// A block of shots that are fired one after the other, nothing being changed between them.
struct Block {
  Cell cell;
  int shots = 0;      ///< still to be fired
  int of = 0;         ///< in the whole block, with those that are done
  std::string words;  ///< for the operator: "position 2, ball 3: 3 shots"
};

struct Value {
  std::string name;  ///< Computed::name
  Cell cell;         ///< empty above its level
  std::string shot;  ///< level shot only
  double value = 0.0;
  double sd = 0.0;                           ///< standard uncertainty
  std::optional<double> degrees_of_freedom;  ///< effective; absent: infinitely many
  double expanded = 0.0;                     ///< half width of the 95 % interval
  std::vector<host::BudgetLine> budget;
};

enum class Outcome {
  pass,  ///< or classified
  fail,
  inconclusive,  ///< the uncertainty leaves it open
  incomplete,    ///< shots are missing
  withheld,      ///< the protocol's document was not read, or an input is missing; `why` says which
};
std::string_view name(Outcome outcome);

struct Verdict {
  std::string requirement;  ///< Computed::name
  Cell cell{};
  std::string shot{};  ///< level shot only
  Outcome outcome = Outcome::incomplete;
  std::string category{};        ///< with categories: the one that is decided for; else empty
  std::optional<double> risk{};  ///< probability that the stated outcome is wrong
  std::string why{};             ///< a sentence, for a person
};

struct Evaluation {
  std::vector<UsedShot> shots;
  std::vector<Block> blocks;  ///< what is left, in the order in which it is to be fired; empty: complete
  int replaced = 0;           ///< shots that were or must be fired again
  bool out_of_replacements = false;
  std::vector<Value> values;
  std::vector<Verdict> verdicts;
  Outcome outcome = Outcome::incomplete;  ///< of all requirements together
  std::string why;
};

/// shots: of one or more sessions, oldest first, with budgets (host::series_shots()). `seed`: of the drawn
/// order.
Evaluation evaluate(const Protocol& protocol, std::uint64_t seed, std::span<const host::Shot> shots);

}  // namespace strobe::protocol
