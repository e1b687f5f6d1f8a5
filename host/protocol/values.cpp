#include "host/protocol/values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/flight/vertical.hpp"
#include "common/units/angles.hpp"
#include "host/protocol/expression.hpp"
#include "host/protocol/formula_check.hpp"
#include "host/protocol/shot_numbers.hpp"

namespace strobe::protocol {
namespace {

using Kind = Expression::Kind;

/// What a formula is computed for: all shots of it, and what it is called.
struct Scope {
  Level level = Level::test;
  Cell cell{};
  std::vector<const CountedShot*> shots{};
};

/// That a number is, and what it is of.
struct Item {
  Cell cell;
  std::string shot;
  Number number;
};

class Computing {
 public:
  Computing(const Protocol& protocol, const std::vector<CountedShot>& shots)
      : protocol_(protocol), shots_(shots), shot_numbers_(computed_.sources) {}

  ComputedNumbers run() && {
    for (const Computed& one : protocol_.computed) {
      std::vector<ComputedNumber>& numbers = computed_.of.emplace_back();
      for (const Scope& scope : scopes(one.level)) {
        ComputedNumber number{scope.cell,
                              one.level == Level::shot ? scope.shots.front()->shot->full_name() : "",
                              value(*one.formula.expression, scope)};
        if (number.number && !is_finite(*number.number)) number.number = fail(one.name + " is not finite");
        numbers.push_back(std::move(number));
      }
    }
    return std::move(computed_);
  }

 private:
  static bool is_finite(const Number& number) {
    return std::isfinite(number.value) &&
           std::ranges::all_of(number.effects, [](const auto& e) { return std::isfinite(e.second); });
  }

  /// All of a level that have shots; the test always.
  std::vector<Scope> scopes(Level level, const std::optional<std::string>& position = {}) const {
    std::vector<Scope> all;
    if (level == Level::test) all.push_back({level});
    for (const CountedShot& shot : shots_) {
      if (position && shot.cell.position != *position) continue;
      const Cell cell = level == Level::test       ? Cell{}
                        : level == Level::position ? Cell{shot.cell.position, ""}
                                                   : shot.cell;
      auto scope = level == Level::shot ? all.end() : std::ranges::find(all, cell, &Scope::cell);
      if (scope == all.end()) scope = all.insert(all.end(), {level, cell});
      scope->shots.push_back(&shot);
    }
    return all;
  }

  Result<Number> value(const Expression& e, const Scope& scope) {
    switch (e.kind) {
      case Kind::number:
        return Number{e.number};
      case Kind::text:
        return fail("'" + e.name + "' is no number");
      case Kind::name:
        return named(e, scope);
      case Kind::call:
        return is_aggregate(e, protocol_) ? aggregate(e, scope) : call(e, scope);
      default:
        break;
    }
    std::vector<Number> arguments;
    for (const Expression& argument : e.arguments) {
      auto number = value(argument, scope);
      if (!number) return number;
      arguments.push_back(std::move(*number));
    }
    return arithmetic(e.kind, arguments.front(), arguments.back());
  }

  static Result<Number> arithmetic(Kind kind, const Number& a, const Number& b) {
    const double x = a.value, y = b.value;
    if (kind == Kind::negate) return function_of(-x, {{&a, -1.0}});
    if (kind == Kind::add) return function_of(x + y, {{&a, 1.0}, {&b, 1.0}});
    if (kind == Kind::subtract) return function_of(x - y, {{&a, 1.0}, {&b, -1.0}});
    if (kind == Kind::multiply) return function_of(x * y, {{&a, y}, {&b, x}});
    if (kind == Kind::divide) return function_of(x / y, {{&a, 1.0 / y}, {&b, -x / (y * y)}});
    // An exact exponent's logarithm, of a base that may be negative, is not needed.
    const double by_y = b.effects.empty() ? 0.0 : std::pow(x, y) * std::log(x);
    return function_of(std::pow(x, y), {{&a, y * std::pow(x, y - 1.0)}, {&b, by_y}});
  }

  Result<Number> named(const Expression& e, const Scope& scope) {
    if (const auto q = quantity_of(e.name)) return shot_numbers_.quantity(*scope.shots.front()->shot, *q);
    const auto computed = std::ranges::find(protocol_.computed, e.name, &Computed::name);
    if (computed != protocol_.computed.end())
      return before(static_cast<std::size_t>(computed - protocol_.computed.begin()), scope);
    return input(*std::ranges::find(protocol_.inputs, e.name, &Input::name), scope);
  }

  /// Of the same cell, or the coarser one that it is in.
  Result<Number> before(std::size_t place, const Scope& scope) const {
    const Level level = protocol_.computed[place].level;
    for (const ComputedNumber& number : computed_.of[place]) {
      const bool same = (level == Level::test || number.cell.position == scope.cell.position) &&
                        (level >= Level::position || number.cell.ball == scope.cell.ball) &&
                        (level != Level::shot || number.shot == scope.shots.front()->shot->full_name());
      if (same) return number.number;
    }
    return fail("there is no " + protocol_.computed[place].name + " yet");
  }

  Result<Number> input(const Input& input, const Scope& scope) {
    Number mean;
    const std::vector<const CountedShot*>& shots = scope.shots;
    for (const CountedShot* shot : shots) {
      const auto one = shot_numbers_.input(*shot->shot, input);
      if (!one) return one;
      mean = function_of(mean.value + one->value / static_cast<double>(shots.size()),
                         {{&mean, 1.0}, {&*one, 1.0 / static_cast<double>(shots.size())}});
    }
    if (shots.empty()) return fail("there are no shots that count yet");
    return mean;
  }

  Result<Number> call(const Expression& e, const Scope& scope) {
    std::vector<Number> arguments;
    for (const Expression& argument : e.arguments) {
      auto number = value(argument, scope);
      if (!number) return number;
      arguments.push_back(std::move(*number));
    }
    const Number& a = arguments.front();
    const double x = a.value, rad = radians(x);
    if (e.name == "uncertainty") return Number{computed_.sources.expanded(a)};
    if (e.name == "abs") return function_of(std::abs(x), {{&a, x < 0.0 ? -1.0 : 1.0}});
    if (e.name == "sqrt") return function_of(std::sqrt(x), {{&a, 0.5 / std::sqrt(x)}});
    if (e.name == "sin") return function_of(std::sin(rad), {{&a, radians(std::cos(rad))}});
    if (e.name == "cos") return function_of(std::cos(rad), {{&a, radians(-std::sin(rad))}});
    if (e.name == "tan")
      return function_of(std::tan(rad), {{&a, radians(1.0 / (std::cos(rad) * std::cos(rad)))}});
    if (e.name == "min") return *std::ranges::min_element(arguments, {}, &Number::value);
    if (e.name == "max") return *std::ranges::max_element(arguments, {}, &Number::value);
    return in_air(e.name, a, scope);
  }

  Result<Number> in_air(const std::string& name, const Number& a, const Scope& scope) {
    if (scope.shots.empty()) return fail("there are no shots that count yet");
    if (a.value < 0.0) return fail(name + " of a negative number");
    const auto drag = shot_numbers_.drag(*scope.shots.front()->shot);
    if (!drag) return tl::unexpected(drag.error());
    const flight::VerticalNumber number = name == "rise" ? flight::rise_m(a.value, drag->drag_per_m)
                                                         : flight::fall_speed_mps(a.value, drag->drag_per_m);
    return function_of(number.value,
                       {{&a, number.by_input}, {&drag->error, number.by_drag_per_m * drag->drag_per_m}});
  }

  Result<Number> aggregate(const Expression& e, const Scope& scope) {
    const Level level = finest_level(e.arguments[0], protocol_);
    std::vector<Item> items;
    for (const Scope& one : scopes(level, position_of(e))) {
      const bool elsewhere =
          (!position_of(e) && scope.level <= Level::position && one.cell.position != scope.cell.position) ||
          (scope.level <= Level::ball && one.cell.ball != scope.cell.ball);
      if (elsewhere) continue;
      auto number = value(e.arguments[0], one);
      if (!number) return number;
      items.push_back(
          {one.cell, level == Level::shot ? one.shots.front()->shot->full_name() : "", std::move(*number)});
    }
    if (e.name == "count") return Number{static_cast<double>(items.size())};
    if (items.empty()) return fail("there are no shots that count yet");
    if (e.name == "mean") return mean(items, level);
    if (e.name == "sd") return sd(items);
    const auto [least, most] =
        std::ranges::minmax_element(items, {}, [](const Item& i) { return i.number.value; });
    if (e.name == "min") return least->number;
    if (e.name == "max") return most->number;
    return function_of(most->number.value - least->number.value,
                       {{&most->number, 1.0}, {&least->number, -1.0}});
  }

  /// Of shots over each ball's, of balls over each position's, of positions.
  Number mean(std::vector<Item> items, Level level) {
    if (level == Level::shot)
      items = means(
          "shots", items, [](const Item& i) { return i.shot; }, [](const Item& i) { return i.cell; });
    if (level <= Level::ball)
      items = means(
          "balls", items, [](const Item& i) { return i.cell.ball; },
          [](const Item& i) {
            return Cell{i.cell.position, ""};
          });
    return means(
               "positions", items, [](const Item& i) { return i.cell.position; },
               [](const Item&) { return Cell{}; })
        .front()
        .number;
  }

  template <typename Name, typename Group>
  std::vector<Item> means(const std::string& kind, const std::vector<Item>& items, Name name, Group group) {
    std::vector<std::pair<Cell, std::vector<std::pair<std::string, Number>>>> groups;
    for (const Item& item : items) {
      const Cell cell = group(item);
      auto found = std::ranges::find_if(groups, [&](const auto& g) { return g.first == cell; });
      if (found == groups.end()) found = groups.insert(groups.end(), {cell, {}});
      found->second.emplace_back(name(item), item.number);
    }
    std::vector<Item> result;
    for (const auto& [cell, members] : groups)
      result.push_back({cell, "", computed_.sources.mean(kind, members)});
    return result;
  }

  static Result<Number> sd(const std::vector<Item>& items) {
    const double n = static_cast<double>(items.size());
    if (items.size() < 2) return fail("an sd needs two numbers");
    double mean = 0.0, squares = 0.0;
    for (const Item& item : items) mean += item.number.value / n;
    for (const Item& item : items) squares += (item.number.value - mean) * (item.number.value - mean);
    Number sd{std::sqrt(squares / (n - 1.0))};
    for (const Item& item : items)
      if (squares > 0.0)
        sd = function_of(sd.value,
                         {{&sd, 1.0}, {&item.number, (item.number.value - mean) / ((n - 1.0) * sd.value)}});
    return sd;
  }

  const Protocol& protocol_;
  const std::vector<CountedShot>& shots_;
  ComputedNumbers computed_;
  ShotNumbers shot_numbers_;
};

}  // namespace

ComputedNumbers compute(const Protocol& protocol, const std::vector<CountedShot>& shots) {
  return Computing(protocol, shots).run();
}

}  // namespace strobe::protocol
