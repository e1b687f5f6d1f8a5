#include "host/protocol/formula_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "common/config/nearest.hpp"

namespace strobe::protocol {
namespace {

using Kind = Expression::Kind;

struct Function {
  std::string_view name;
  std::size_t least, most;  ///< arguments
};

constexpr std::array<Function, 10> kFunctions{{{"abs", 1, 1},
                                               {"sqrt", 1, 1},
                                               {"sin", 1, 1},
                                               {"cos", 1, 1},
                                               {"tan", 1, 1},
                                               {"min", 2, 20},
                                               {"max", 2, 20},
                                               {"uncertainty", 1, 1},
                                               {"rise", 1, 1},
                                               {"fall_speed", 1, 1}}};
constexpr std::array<std::string_view, 6> kAggregates{"mean", "sd", "spread", "min", "max", "count"};

const Computed* computed_of(const Protocol& protocol, std::string_view name) {
  const auto found = std::ranges::find(protocol.computed, name, &Computed::name);
  return found == protocol.computed.end() ? nullptr : &*found;
}

bool is_input(const Protocol& protocol, std::string_view name) {
  return std::ranges::find(protocol.inputs, name, &Input::name) != protocol.inputs.end();
}

bool is_position(const Protocol& protocol, std::string_view name) {
  return std::ranges::find(protocol.positions, name) != protocol.positions.end();
}

class Checker {
 public:
  Checker(Level level, const Protocol& protocol) : level_(level), protocol_(protocol) {}

  std::string wrong;

  void check(const Expression& e, bool in_aggregate) {
    if (!wrong.empty()) return;
    if (e.kind == Kind::name) return check_name(e, in_aggregate);
    if (e.kind == Kind::text) return refuse(e, "a text stands where a number must");
    if (e.kind != Kind::call) {
      for (const Expression& argument : e.arguments) check(argument, in_aggregate);
      return;
    }
    if (is_aggregate(e, protocol_)) return check_aggregate(e, in_aggregate);
    check_call(e);
    for (const Expression& argument : e.arguments) check(argument, in_aggregate);
  }

 private:
  void refuse(const Expression& e, const std::string& what) {
    if (wrong.empty()) wrong = fmt::format("at character {}: {}", e.at, what);
  }

  void check_name(const Expression& e, bool in_aggregate) {
    if (!is_known(protocol_, e.name))
      return refuse(
          e, fmt::format("no number {}{}", e.name, config::did_you_mean(e.name, known_names(protocol_))));
    if (in_aggregate || is_input(protocol_, e.name)) return;
    const Level its = finest_level(e, protocol_);
    if (its < level_)
      refuse(e, fmt::format("{} is of each {}: say of which, as mean({})", e.name, name(its), e.name));
  }

  void check_call(const Expression& e) {
    const auto known = std::ranges::find(kFunctions, e.name, &Function::name);
    if (known == kFunctions.end()) return refuse(e, no_function(e.name));
    if (e.arguments.size() < known->least || e.arguments.size() > known->most)
      refuse(e, fmt::format("{}: wrong number of arguments", e.name));
  }

  static std::string no_function(const std::string& name) {
    std::vector<std::string> names(kAggregates.begin(), kAggregates.end());
    for (const Function& f : kFunctions) names.emplace_back(f.name);
    return fmt::format("no function {}{}", name, config::did_you_mean(name, names));
  }

  void check_aggregate(const Expression& e, bool in_aggregate) {
    if (in_aggregate) return refuse(e, e.name + " stands within another of its kind");
    if (e.arguments.empty() || e.arguments.size() > 2)
      return refuse(e, e.name + ": must be of one number, perhaps at one position");
    check(e.arguments[0], true);
    if (!wrong.empty()) return;
    if (const auto position = position_of(e); position && !is_position(protocol_, *position))
      return refuse(e.arguments[1], fmt::format("no position {}; there are {}", *position,
                                                fmt::join(protocol_.positions, ", ")));
    if (e.arguments.size() == 2 && !position_of(e))
      return refuse(e.arguments[1], "must be a position's name");
    if (e.arguments.size() == 2 && level_ < Level::position)
      return refuse(e.arguments[1], "a position stands in what is of a position or of the test");
    if (finest_level(e.arguments[0], protocol_) >= level_)
      refuse(e, fmt::format("{} must be of what is finer than the {}", e.name, name(level_)));
  }

  const Level level_;
  const Protocol& protocol_;
};

}  // namespace

std::optional<reduction::Quantity> quantity_of(std::string_view name) {
  const auto found = std::ranges::find(reduction::kQuantityNames, name);
  if (found == reduction::kQuantityNames.end()) return std::nullopt;
  return static_cast<reduction::Quantity>(found - reduction::kQuantityNames.begin());
}

std::vector<std::string> known_names(const Protocol& protocol) {
  std::vector<std::string> names(reduction::kQuantityNames.begin(), reduction::kQuantityNames.end());
  for (const Input& input : protocol.inputs) names.push_back(input.name);
  for (const Computed& computed : protocol.computed) names.push_back(computed.name);
  return names;
}

bool is_known(const Protocol& protocol, std::string_view name) {
  return quantity_of(name) || is_input(protocol, name) || computed_of(protocol, name);
}

std::optional<std::string> position_of(const Expression& aggregate) {
  if (aggregate.arguments.size() != 2) return std::nullopt;
  const Expression& position = aggregate.arguments[1];
  if (position.kind != Kind::text && position.kind != Kind::name) return std::nullopt;
  return position.name;
}

bool is_aggregate(const Expression& call, const Protocol& protocol) {
  if (call.kind != Kind::call || std::ranges::find(kAggregates, call.name) == kAggregates.end()) return false;
  if (call.name != "min" && call.name != "max") return true;
  const auto position = position_of(call);
  return call.arguments.size() < 2 ||
         (position && (call.arguments[1].kind == Kind::text || is_position(protocol, *position)));
}

Level finest_level(const Expression& e, const Protocol& protocol) {
  if (e.kind == Kind::name) {
    const Computed* computed = computed_of(protocol, e.name);
    return computed ? computed->level : Level::shot;
  }
  Level finest = Level::test;
  for (const Expression& argument : e.arguments)
    if (!(argument.kind == Kind::name && is_input(protocol, argument.name)))
      finest = std::min(finest, finest_level(argument, protocol));
  return finest;
}

Result<void> check_formula(const Formula& formula, Level level, const Protocol& protocol) {
  Checker checker(level, protocol);
  checker.check(*formula.expression, false);
  if (!checker.wrong.empty()) return fail(checker.wrong);
  return {};
}

std::string_view name(Level level) {
  constexpr std::array<std::string_view, 4> kNames{"shot", "ball", "position", "test"};
  return kNames[static_cast<std::size_t>(level)];
}

}  // namespace strobe::protocol
