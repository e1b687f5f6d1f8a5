#include "host/protocol/evaluation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <map>
#include <numeric>

#include "host/config/notes.hpp"
#include "host/protocol/formula_check.hpp"
#include "host/protocol/values.hpp"
#include "host/text/text.hpp"

namespace strobe::protocol {
namespace {

std::string note_of(const host::Shot& shot, std::string_view key) {
  const auto note = shot.readout.record.find(std::string(key));
  return note == shot.readout.record.end() ? "" : note->second;
}

bool is_within(double value, const Interval& interval) {
  return value >= interval.low && value <= interval.high;
}

/// Why the shot does not conform; empty: it does. What it lacks does not conform.
std::string nonconformity(const Protocol& protocol, const host::Shot& shot) {
  const auto judged = [](const std::string& name, std::optional<double> value, const Interval& allowed) {
    if (!value) return "no " + name;
    if (is_within(*value, allowed)) return std::string();
    return fmt::format("{} is {:.4g}, must be {}", name, *value, words(allowed));
  };
  for (const Conformance& c : protocol.conforms) {
    const auto q = quantity_of(c.quantity);
    std::optional<double> value;
    if (q) value = shot.readout.value[*q];
    if (!q) {
      const Input& input = *std::ranges::find(protocol.inputs, c.quantity, &Input::name);
      value = host::note_number(shot.readout.record, input.name);
      if (!value) value = input.value;
    }
    if (auto why = judged(c.quantity, value, c.allowed); !why.empty()) return why;
  }
  for (const Input& input : protocol.inputs) {
    const auto noted = host::note_number(shot.readout.record, input.name);
    if (!noted) continue;  // said of what is computed of it
    if (auto why = judged(input.name, noted, input.allowed); !why.empty()) return why;
  }
  return "";
}

/// Cells, which shots are of them, and what is left of each.
class Course {
 public:
  Course(const Protocol& protocol, std::uint64_t seed, std::span<const host::Shot> shots)
      : protocol_(protocol), seed_(seed) {
    name_balls(shots);
    for (const host::Shot& shot : shots)
      if (!shot.dry) add(shot);
  }

  std::vector<UsedShot> used;
  std::vector<CountedShot> counted;
  int replaced = 0;

  std::vector<Block> left() const {
    std::vector<Block> blocks;
    for (std::size_t p = 0; p < protocol_.positions.size(); ++p) {
      for (const std::size_t b : order(p)) {
        const Cell cell{protocol_.positions[p], balls_[b]};
        const int first = p == 0 ? protocol_.discarded : 0;
        Block block{cell, std::max(0, protocol_.repeats - count(counted_, cell)), protocol_.repeats + first,
                    ""};
        if (p == 0) block.shots += std::max(0, first - count(impacts_, {"", cell.ball}));
        if (block.shots == 0) continue;
        block.words = block_words(block);
        blocks.push_back(std::move(block));
      }
    }
    return blocks;
  }

 private:
  using Counts = std::vector<std::pair<Cell, int>>;

  static int count(const Counts& counts, const Cell& cell) {
    const auto found = std::ranges::find(counts, cell, &Counts::value_type::first);
    return found == counts.end() ? 0 : found->second;
  }

  static void increase(Counts& counts, const Cell& cell) {
    const auto found = std::ranges::find(counts, cell, &Counts::value_type::first);
    if (found == counts.end())
      counts.emplace_back(cell, 1);
    else
      ++found->second;
  }

  bool is_of_this(const host::Shot& shot) const {
    const std::string note = note_of(shot, kProtocolNote);
    return note.empty() || note == protocol_.name;
  }

  /// Numbers are the balls' places in the order; other names take free places as they come.
  void name_balls(std::span<const host::Shot> shots) {
    const auto n = static_cast<std::size_t>(protocol_.balls);
    std::vector<std::string> numbers, seen;
    for (std::size_t i = 1; i <= n; ++i) numbers.push_back(std::to_string(i));
    for (const host::Shot& shot : shots) {
      const std::string ball = note_of(shot, kBallNote);
      if (!ball.empty() && is_of_this(shot) && std::ranges::find(seen, ball) == seen.end())
        seen.push_back(ball);
    }
    balls_.assign(n, "");
    for (std::size_t i = 0; i < n; ++i)
      if (std::ranges::find(seen, numbers[i]) != seen.end()) balls_[i] = numbers[i];
    for (const std::string& ball : seen) {
      const auto free = std::ranges::find(balls_, "");
      if (std::ranges::find(numbers, ball) == numbers.end() && free != balls_.end()) *free = ball;
    }
    for (std::size_t i = 0; i < n; ++i)
      if (balls_[i].empty()) balls_[i] = numbers[i];
  }

  Cell cell_of(const host::Shot& shot) const {
    Cell cell{note_of(shot, kPositionNote), note_of(shot, kBallNote)};
    if (cell.position.empty() && protocol_.positions.size() == 1) cell.position = protocol_.positions[0];
    if (cell.ball.empty() && protocol_.balls == 1) cell.ball = balls_[0];
    return cell;
  }

  void add(const host::Shot& shot) {
    UsedShot one{shot.full_name(), cell_of(shot), Use::counts, ""};
    const bool known =
        is_of_this(shot) &&
        std::ranges::find(protocol_.positions, one.cell.position) != protocol_.positions.end() &&
        std::ranges::find(balls_, one.cell.ball) != balls_.end();
    if (!known) {
      one.use = Use::surplus;
      one.why = "it is of no ball and position of this protocol";
    } else if (count(impacts_, {"", one.cell.ball}) < protocol_.discarded) {
      one.use = Use::discarded;
      one.why = "a first impact of its ball";
    } else if (count(counted_, one.cell) == protocol_.repeats) {
      one.use = Use::surplus;
      one.why = "its ball had all its shots there";
    } else if (shot.rejected) {
      one.use = Use::rejected;
      one.why = *shot.rejected;
    } else if (shot.readout.flags.has(reduction::Flag::air_not_fitted)) {  // e may be off by a twentieth
      one.use = Use::rejected;
      one.why = host::words(reduction::Flag::air_not_fitted);
    } else if (one.why = nonconformity(protocol_, shot); !one.why.empty()) {
      one.use = Use::not_conforming;
    }
    if (known) increase(impacts_, {"", one.cell.ball});
    if (one.use == Use::counts) {
      increase(counted_, one.cell);
      counted.push_back({one.cell, &shot});
    }
    if (one.use == Use::rejected || one.use == Use::not_conforming) ++replaced;
    used.push_back(std::move(one));
  }

  /// Fisher and Yates's shuffle, the same with every standard library.
  std::vector<std::size_t> order(std::size_t position) const {
    std::vector<std::size_t> order(balls_.size());
    std::iota(order.begin(), order.end(), 0U);
    if (!protocol_.drawn_order) return order;
    boost::random::mt19937_64 random(seed_);
    for (std::size_t p = 0; p <= position; ++p)
      for (std::size_t i = order.size(); i > 1; --i)
        std::swap(order[i - 1],
                  order[boost::random::uniform_int_distribution<std::size_t>(0, i - 1)(random)]);
    return order;
  }

  std::string block_words(const Block& block) const {
    std::string text;
    if (protocol_.positions.size() > 1) text += "position " + block.cell.position + ", ";
    if (protocol_.balls > 1) text += "ball " + block.cell.ball + ", ";
    if (text.size() > 2) text.replace(text.size() - 2, 2, ": ");
    return text + fmt::format("{} shot{}", block.shots, block.shots == 1 ? "" : "s");
  }

  const Protocol& protocol_;
  std::uint64_t seed_;
  std::vector<std::string> balls_;
  Counts counted_, impacts_;  ///< impacts: with no position
};

std::string place_of(const Cell& cell, const std::string& shot) {
  return shot.empty() ? words(cell) : "shot " + shot;
}

Measured measured(const Value& value) {
  Measured m{value.value, value.sd};
  if (value.degrees_of_freedom) m.degrees_of_freedom = *value.degrees_of_freedom;
  return m;
}

Outcome outcome_of(Decision decision) {
  if (decision == Decision::pass) return Outcome::pass;
  return decision == Decision::fail ? Outcome::fail : Outcome::inconclusive;
}

std::string result_text(const Value& v) {
  if (!(v.sd > 0.0)) return fmt::format("{:.6g}", v.value);
  return host::rounded(v.value, v.expanded) + " ± " + host::rounded(v.expanded, v.expanded);
}

void decide_limits(const Requirement& r, const Value& value, Verdict& verdict) {
  const Decided decided = decide(measured(value), r.limits, r.rule, r.risk);
  verdict.outcome = outcome_of(decided.decision);
  verdict.risk = decided.risk;
  verdict.why = fmt::format("{}, must be {}: so with a probability of {}", result_text(value),
                            words(r.limits), percent(decided.probability));
}

/// The likeliest category, if it is likely enough.
void decide_category(const Requirement& r, const Value& value, Verdict& verdict) {
  const Category* best = nullptr;
  double probability = -1.0;
  for (const Category& c : r.categories) {
    const Decided decided = decide(measured(value), c.range, r.rule, r.risk);
    const bool better = r.rule == DecisionRule::simple ? decided.decision == Decision::pass && best == nullptr
                                                       : decided.probability > probability;
    if (!better) continue;
    best = &c;
    probability = decided.probability;
    verdict.outcome = decided.decision == Decision::pass ? Outcome::pass : Outcome::inconclusive;
  }
  if (best == nullptr) {
    verdict.outcome = Outcome::fail;
    verdict.why = result_text(value) + " is in no category";
    return;
  }
  verdict.risk = 1.0 - probability;
  if (verdict.outcome == Outcome::pass) verdict.category = best->name;
  verdict.why =
      fmt::format("{}: {} with a probability of {}", result_text(value), best->name, percent(probability));
}

/// Of one of the numbers of a requirement.
Verdict verdict_of(const Protocol& protocol, const Requirement& r, const Value& value) {
  Verdict verdict{.requirement = r.name, .cell = value.cell, .shot = value.shot};
  if (protocol.source.read == SourceRead::not_read) {
    verdict.outcome = Outcome::withheld;
    verdict.why = protocol.source.document + " was not read by those who wrote this protocol";
  } else if (r.categories.empty()) {
    decide_limits(r, value, verdict);
  } else {
    decide_category(r, value, verdict);
  }
  const std::string place = place_of(value.cell, value.shot);
  if (!place.empty()) verdict.why = place + ": " + verdict.why;
  return verdict;
}

Value value_of(const Sources& sources, const std::string& name, const ComputedNumber& number) {
  return {name,
          number.cell,
          number.shot,
          number.number->value,
          sources.sd(*number.number),
          sources.degrees_of_freedom(*number.number),
          sources.expanded(*number.number),
          sources.budget(*number.number)};
}

class Judging {
 public:
  Judging(const Protocol& protocol, const std::vector<CountedShot>& counted, Evaluation& evaluation)
      : protocol_(protocol), numbers_(compute(protocol, counted)), evaluation_(evaluation) {}

  void run(bool complete) {
    for (std::size_t i = 0; i < protocol_.computed.size(); ++i)
      for (const ComputedNumber& number : numbers_.of[i])
        if (number.number)
          evaluation_.values.push_back(value_of(numbers_.sources, protocol_.computed[i].name, number));
    for (const Requirement& r : protocol_.requirements) judge(r, complete);
  }

 private:
  void judge(const Requirement& r, bool complete) {
    if (!complete) {
      evaluation_.verdicts.push_back(
          {.requirement = r.name, .outcome = Outcome::incomplete, .why = "shots are missing"});
      return;
    }
    const auto computed = std::ranges::find(protocol_.computed, r.name, &Computed::name);
    for (const ComputedNumber& number :
         numbers_.of[static_cast<std::size_t>(computed - protocol_.computed.begin())]) {
      if (number.number)
        evaluation_.verdicts.push_back(verdict_of(protocol_, r, value_of(numbers_.sources, r.name, number)));
      else
        evaluation_.verdicts.push_back({.requirement = r.name,
                                        .cell = number.cell,
                                        .shot = number.shot,
                                        .outcome = Outcome::withheld,
                                        .why = number.number.error().message});
    }
  }

  const Protocol& protocol_;
  ComputedNumbers numbers_;
  Evaluation& evaluation_;
};

/// One requirement that fails, fails all; else what is open is so for all.
void conclude(const Protocol& protocol, Evaluation& e) {
  e.outcome = Outcome::pass;
  e.why =
      protocol.requirements.empty() ? "complete; this protocol decides nothing" : "all requirements are met";
  for (const Outcome outcome :
       {Outcome::fail, Outcome::withheld, Outcome::incomplete, Outcome::inconclusive}) {
    const auto found = std::ranges::find(e.verdicts, outcome, &Verdict::outcome);
    if (found == e.verdicts.end()) continue;
    e.outcome = outcome;
    e.why = found->requirement + ": " + found->why;
    return;
  }
}

}  // namespace

std::string words(const Cell& cell) {
  if (cell.position.empty()) return "";
  return "position " + cell.position + (cell.ball.empty() ? "" : ", ball " + cell.ball);
}

std::string_view name(Outcome outcome) {
  constexpr std::array<std::string_view, 5> kNames{"pass", "fail", "inconclusive", "incomplete", "withheld"};
  return kNames[static_cast<std::size_t>(outcome)];
}

Evaluation evaluate(const Protocol& protocol, std::uint64_t seed, std::span<const host::Shot> shots) {
  const Course course(protocol, seed, shots);
  Evaluation evaluation;
  evaluation.shots = course.used;
  evaluation.blocks = course.left();
  evaluation.replaced = course.replaced;
  evaluation.out_of_replacements = course.replaced > protocol.replacements;
  const bool complete = evaluation.blocks.empty() && !evaluation.out_of_replacements;
  Judging(protocol, course.counted, evaluation).run(complete);
  conclude(protocol, evaluation);
  if (complete) return evaluation;
  evaluation.outcome = Outcome::incomplete;
  int missing = 0;
  for (const Block& block : evaluation.blocks) missing += block.shots;
  evaluation.why = evaluation.out_of_replacements
                       ? fmt::format("{} shots had to be fired again; the protocol allows {}",
                                     course.replaced, protocol.replacements)
                       : fmt::format("{} shot{} missing", missing, missing == 1 ? " is" : "s are");
  return evaluation;
}

}  // namespace strobe::protocol
