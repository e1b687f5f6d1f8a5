// Formulas: what is read is what is written, derivatives are those of differences, and the uncertainty is that of draws.
#include <rapidcheck.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/host/protocol/protocol_shots.hpp"
#include "tests/support/property.hpp"

using namespace strobe;
using namespace strobe::test;
using namespace strobe::testing;

namespace {

constexpr double kX = 1.3, kXSd = 1e-3, kY = 0.7, kYSd = 2e-3;

/// A formula of x and y that the test writes and computes by itself.
struct Tree {
  char kind = 'x';  ///< x, y, a number '1', operators, or 's' sqrt, 'c' cos, 'a' abs, 'm' the larger of both
  double number = 0.0;
  std::vector<Tree> of{};

  double value(double x, double y) const {
    const auto at = [&](std::size_t i) { return of[i].value(x, y); };
    switch (kind) {
      case 'x': return x;
      case 'y': return y;
      case '1': return number;
      case '+': return at(0) + at(1);
      case '-': return at(0) - at(1);
      case '*': return at(0) * at(1);
      case '/': return at(0) / at(1);
      case '^': return std::pow(at(0), at(1));
      case 'n': return -at(0);
      case 's': return std::sqrt(at(0));
      case 'c': return std::cos(at(0) * std::acos(-1.0) / 180.0);
      case 'a': return std::abs(at(0));
      default: return std::max(at(0), at(1));
    }
  }

  int rank() const {
    if (kind == '+' || kind == '-') return 1;
    if (kind == '*' || kind == '/') return 2;
    if (kind == 'n') return 3;
    return kind == '^' ? 4 : 5;
  }

  /// With parentheses only where the usual rules need them.
  std::string text() const {
    const auto in = [&](std::size_t i, int least) {
      return of[i].rank() < least ? "(" + of[i].text() + ")" : of[i].text();
    };
    switch (kind) {
      case 'x': return "x";
      case 'y': return "y";
      case '1': return fmt::format("{}", number);
      case 'n': return "-" + in(0, 3);
      case '^': return in(0, 5) + "^" + in(1, 3);
      case 's': return "sqrt(" + of[0].text() + ")";
      case 'c': return "cos(" + of[0].text() + ")";
      case 'a': return "abs(" + of[0].text() + ")";
      case 'm': return "max(" + of[0].text() + ", " + of[1].text() + ")";
      default: return in(0, rank()) + " " + kind + " " + in(1, rank() + 1);
    }
  }
};

Tree drawn_tree(int depth) {
  constexpr std::string_view kLeaves = "xy1", kOne = "nsca", kTwo = "+-*/^m";
  const auto pick = [](std::string_view of) { return of[static_cast<std::size_t>(*rc::gen::inRange(0, static_cast<int>(of.size())))]; };
  if (depth == 0 || one_in(5)) return {pick(kLeaves), *rc::gen::inRange(1, 400) / 100.0};
  if (one_in(3)) return {pick(kOne), 0.0, {drawn_tree(depth - 1)}};
  return {pick(kTwo), 0.0, {drawn_tree(depth - 1), drawn_tree(depth - 1)}};
}

constexpr const char* kInputs =
    "[[input]]\nname = \"x\"\nwords = \"x\"\nsd = 1e-3\nvalue = 1.3\n"
    "[[input]]\nname = \"y\"\nwords = \"y\"\nsd = 2e-3\nvalue = 0.7\n";

/// Of one shot. Absent where there is no finite number.
std::optional<protocol::Value> evaluated(const std::string& formula) {
  const auto p = protocol_of("repeats = 1", kInputs + computed("f", "shot", formula));
  const auto evaluation = protocol::evaluate(p, 0, protocol_shots({{}}));
  return evaluation.values.empty() ? std::nullopt : std::optional(evaluation.values.front());
}

std::string refusal(const std::string& formula, const std::string& level = "shot") {
  const auto read = protocol::read_protocol(
      protocol_text("repeats = 1\npositions = [\"sample\", \"concrete\"]", kInputs + computed("f", level, formula)), "a.toml");
  return read ? "" : read.error().message;
}

}  // namespace

TEST_GROUP(ProtocolFormula){};

// The same operations in the same order, but for powers and angles: a few roundings each.
TEST(ProtocolFormula, ComputesWhatIsWritten) {
  CHECK_TRUE(holds_of_all([](Worst& worst) {
    const Tree tree = drawn_tree(4);
    const double truth = tree.value(kX, kY);
    RC_PRE(std::isfinite(truth) && std::abs(truth) < 1e9);
    RC_LOG() << tree.text() << '\n';
    const auto value = evaluated(tree.text());
    if (!value) return;  // its derivative is not finite: as of sqrt(0)
    RC_ASSERT(worst.within(std::abs(value->value - truth), 1e-12 * (1.0 + std::abs(truth))));
  }));
}

// Central differences with a step of 1e-6: their own error is some 1e-12 of the third derivative and 1e-10 of rounding;
// where the formula bends sharply they are no truth, which differences with twice the step tell.
TEST(ProtocolFormula, PropagatesUncertaintyAsDifferencesDo) {
  CHECK_TRUE(holds_of_all([](Worst& worst) {
    const Tree tree = drawn_tree(3);
    const auto slope = [&](double dx, double dy) {
      return (tree.value(kX + dx, kY + dy) - tree.value(kX - dx, kY - dy)) / (2.0 * (dx + dy));
    };
    const double by_x = slope(1e-6, 0.0), by_y = slope(0.0, 1e-6);
    const double error = std::abs(slope(2e-6, 0.0) - by_x) + std::abs(slope(0.0, 2e-6) - by_y);
    const double size = std::abs(tree.value(kX, kY)) + std::abs(by_x) + std::abs(by_y);
    RC_PRE(std::isfinite(size) && size < 1e6 && error < 1e-6 * (1.0 + size));
    RC_LOG() << tree.text() << '\n';
    const auto value = evaluated(tree.text());
    if (!value) return;
    const double truth = std::hypot(by_x * kXSd, by_y * kYSd);
    RC_ASSERT(worst.within(std::abs(value->sd - truth), 1e-3 * (1e-6 * (1.0 + size) + error)));
  }));
}

// 20,000 draws know an sd to 1/sqrt(40,000) = 0.5 %; four of these.
TEST(ProtocolFormula, HasTheUncertaintyOfDraws) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> x(kX, kXSd), y(kY, kYSd);
  for (const auto& [formula, f] : std::vector<std::pair<std::string, double (*)(double, double)>>{
           {"100*(1 - x) + 150*(0.81 - (y + 0.003*(23 - x)))",
            [](double a, double b) { return 100 * (1 - a) + 150 * (0.81 - (b + 0.003 * (23 - a))); }},
           {"x/y - x", [](double a, double b) { return a / b - a; }},
           {"sqrt(x*y)^3", [](double a, double b) { return std::pow(a * b, 1.5); }}}) {
    double sum = 0.0, squares = 0.0;
    constexpr int kDraws = 20000;
    const double centre = f(kX, kY);
    for (int i = 0; i < kDraws; ++i) {
      const double off = f(x(random), y(random)) - centre;
      sum += off;
      squares += off * off;
    }
    const double sd = std::sqrt((squares - sum * sum / kDraws) / (kDraws - 1));
    DOUBLES_EQUAL(1.0, evaluated(formula)->sd / sd, 0.02);
  }
}

TEST(ProtocolFormula, TellsWhatIsWrongAndWhere) {
  const auto check = [](const std::string& formula, const std::string& what) {
    const std::string said = refusal(formula);
    if (said.find(what) == said.npos) FAIL((formula + ": " + said).c_str());
    CHECK_TRUE(said.starts_with("a.toml:"));
  };
  check("x +", "at character 4: a number or a name is missing");
  check("2 x", "at character 3: an operator is missing");
  check("(x", "a closing parenthesis is missing");
  check("x + speed", "at character 5: no number speed");
  check("sqr(x)", "no function sqr; did you mean sqrt?");
  check("sqrt(x, y)", "wrong number of arguments");
  check("mean(e)", "must be of what is finer than the shot");
  check("1e999", "is no number");
  check(std::string(200, '('), "too many parentheses");
  check(std::string(200, '-') + "1", "too many signs");
  CHECK_TRUE(refusal("e", "test").find("e is of each shot: say of which, as mean(e)") != std::string::npos);
  CHECK_TRUE(refusal("mean(e, grass)", "test").find("no position grass; there are sample, concrete") != std::string::npos);
  CHECK_EQUAL(std::string(), refusal("100*mean(e, sample)/mean(e, 'concrete') + min(e) - max(e, sample)", "test"));
}
