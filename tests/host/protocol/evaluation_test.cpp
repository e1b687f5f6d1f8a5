// What a session's shots are to a protocol, and what its numbers are worth.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "tests/host/protocol/protocol_shots.hpp"

using namespace strobe;
using namespace strobe::test;
using protocol::Outcome;
using protocol::Use;

namespace {

constexpr const char* kConforming = "[[conforms]]\nquantity = \"mu\"\nleast = 0.4\nmost = 0.6\n";

std::vector<std::string> left(const protocol::Evaluation& e) {
  std::vector<std::string> words;
  for (const protocol::Block& block : e.blocks) words.push_back(block.words);
  return words;
}

std::string requirement(const std::string& name, const std::string& limits) {
  return "[[requirement]]\nname = \"" + name + "\"\n" + limits + "\n";
}

}  // namespace

TEST_GROUP(ProtocolEvaluation){};

// Of .80, .82, .84: sd .02, standard error .02/sqrt(3); the scale's .01 does not become smaller. Two degrees of freedom
// of the scatter: Welch-Satterthwaite.
TEST(ProtocolEvaluation, AMeanHasItsScatterAndWhatItsShotsShare) {
  const auto p = protocol_of("repeats = 3", computed("m", "test", "mean(e)"));
  const auto e = protocol::evaluate(p, 0, protocol_shots({{.e = 0.80, .own = 0.003}, {.e = 0.82}, {.e = 0.84}}));
  const protocol::Value& m = value_of(e, "m");
  DOUBLES_EQUAL(0.82, m.value, 1e-12);
  DOUBLES_EQUAL(std::sqrt(0.0004 / 3.0 + 0.0001), m.sd, 1e-12);
  DOUBLES_EQUAL(2.0 * std::pow(1.0 + 0.0003 / 0.0004, 2), *m.degrees_of_freedom, 1e-9);
  CHECK_EQUAL(std::string("scatter of the shots"), m.budget[0].source);
  CHECK_EQUAL(std::string("scale"), m.budget[1].source);
}

TEST(ProtocolEvaluation, MeansOfTheSameShotsVaryTogether) {
  const auto p = protocol_of("repeats = 3", computed("d", "test", "mean(e) - mean(mu)") + computed("x", "shot", "e - mu") +
                                                computed("y", "test", "mean(x)"));
  const auto e = protocol::evaluate(
      p, 0, protocol_shots({{.e = 0.80, .mu = 0.50}, {.e = 0.82, .mu = 0.53}, {.e = 0.84, .mu = 0.51}}));
  DOUBLES_EQUAL(value_of(e, "y").sd, value_of(e, "d").sd, 1e-15);
  DOUBLES_EQUAL(*value_of(e, "y").degrees_of_freedom, *value_of(e, "d").degrees_of_freedom, 1e-9);
}

// e of a position .9 of the other's, ball by ball: the ratio is exact, whatever balls and scale are.
TEST(ProtocolEvaluation, ARatioOfPositionsLosesWhatBothShare) {
  const auto p = protocol_of("repeats = 1\nballs = 3\npositions = [\"sample\", \"concrete\"]",
                             computed("percent", "test", "100*mean(e, sample)/mean(e, concrete)"));
  std::vector<ProtocolShot> made;
  for (const double e : {0.7, 0.72, 0.77}) {
    const std::string ball = std::to_string(made.size() / 2 + 1);
    made.push_back({.position = "sample", .ball = ball, .e = 0.9 * e, .by_scale = 0.9 * 0.02});
    made.push_back({.position = "concrete", .ball = ball, .e = e, .by_scale = 0.02});
  }
  const auto e = protocol::evaluate(p, 0, protocol_shots(made));
  DOUBLES_EQUAL(90.0, value_of(e, "percent").value, 1e-10);
  DOUBLES_EQUAL(0.0, value_of(e, "percent").sd, 1e-10);
}

// Balls' means are .80, .82, .84, whatever their shots are about them; two degrees of freedom.
TEST(ProtocolEvaluation, BallsAreTheSampleNotTheirShots) {
  const auto p = protocol_of("repeats = 2\nballs = 3", computed("m", "test", "mean(e)"));
  std::vector<ProtocolShot> made;
  for (const double e : {0.80, 0.82, 0.84})
    for (const double off : {-0.01, 0.01})
      made.push_back({.ball = std::to_string(made.size() / 2 + 1), .e = e + off, .by_scale = 0.0});
  const auto e = protocol::evaluate(p, 0, protocol_shots(made));
  DOUBLES_EQUAL(0.02 / std::sqrt(3.0), value_of(e, "m").sd, 1e-12);
  DOUBLES_EQUAL(2.0, *value_of(e, "m").degrees_of_freedom, 1e-9);
}

// Balls alike by chance: means of two shots that are .06 apart have an sd of .03, that of two balls .03/sqrt(2), whose
// sds have one degree of freedom each.
TEST(ProtocolEvaluation, AMeanIsNoMoreCertainThanItsItems) {
  const auto p = protocol_of("repeats = 2\nballs = 2", computed("m", "test", "mean(e)"));
  const auto e = protocol::evaluate(p, 0, protocol_shots({{.ball = "1", .e = 0.77, .by_scale = 0.0},
                                                          {.ball = "1", .e = 0.83, .by_scale = 0.0},
                                                          {.ball = "2", .e = 0.77, .by_scale = 0.0},
                                                          {.ball = "2", .e = 0.83, .by_scale = 0.0}}));
  DOUBLES_EQUAL(0.03 / std::sqrt(2.0), value_of(e, "m").sd, 1e-12);
  DOUBLES_EQUAL(2.0, *value_of(e, "m").degrees_of_freedom, 1e-9);
}

// var(e + mu) = 2 s^2 (1 + r), of the difference 2 s^2 (1 - r).
TEST(ProtocolEvaluation, AShotsNumbersKeepTheirCovariance) {
  const auto p = protocol_of("repeats = 1", computed("sum", "shot", "e + mu") + computed("difference", "shot", "e - mu"));
  const auto e = protocol::evaluate(p, 0, protocol_shots({{.by_scale = 0.0, .own = 0.01, .correlation = -0.8}}));
  DOUBLES_EQUAL(0.01 * std::sqrt(2.0 * 0.2), value_of(e, "sum").sd, 1e-9);
  DOUBLES_EQUAL(0.01 * std::sqrt(2.0 * 1.8), value_of(e, "difference").sd, 1e-9);
}

TEST(ProtocolEvaluation, SpreadAndExtremesAreOfTheseShots) {
  const auto p = protocol_of("repeats = 3", computed("s", "test", "spread(e)") + computed("l", "test", "min(e)") +
                                                computed("n", "test", "count(e)") + computed("d", "test", "sd(e)"));
  const auto e = protocol::evaluate(
      p, 0, protocol_shots({{.e = 0.80, .own = 0.003}, {.e = 0.81, .own = 0.1}, {.e = 0.84, .own = 0.004}}));
  DOUBLES_EQUAL(0.04, value_of(e, "s").value, 1e-12);
  DOUBLES_EQUAL(0.005, value_of(e, "s").sd, 1e-12);  // the scale is the same of both
  DOUBLES_EQUAL(std::hypot(0.003, 0.01), value_of(e, "l").sd, 1e-12);
  DOUBLES_EQUAL(3.0, value_of(e, "n").value, 0.0);
  DOUBLES_EQUAL(std::sqrt((0.05 * 0.05 + 0.02 * 0.02 + 0.07 * 0.07) / 9.0 / 2.0), value_of(e, "d").value, 1e-12);
}

TEST(ProtocolEvaluation, TellsWhichShotsCountAndWhatIsLeft) {
  const auto p = protocol_of("repeats = 2\nballs = 2\ndiscarded = 1\nreplacements = 2", kConforming);
  auto shots = protocol_shots({{.ball = "1"}, {.ball = "1", .mu = 0.7}, {.ball = "1"}, {.ball = "1"}, {.ball = "1"}, {.ball = "9"},
                               {.ball = "8"}, {.ball = "2"}, {.ball = "2"}});
  shots[8].rejected = "no photograph";
  const auto e = protocol::evaluate(p, 0, shots);
  std::vector<Use> uses;
  for (const auto& shot : e.shots) uses.push_back(shot.use);
  CHECK_TRUE((uses == std::vector<Use>{Use::discarded, Use::not_conforming, Use::counts, Use::counts, Use::surplus,
                                       Use::surplus, Use::surplus, Use::discarded, Use::rejected}));
  CHECK_EQUAL(std::string("mu is 0.7, must be 0.4 to 0.6"), e.shots[1].why);
  CHECK_EQUAL(2, e.replaced);
  CHECK_TRUE((left(e) == std::vector<std::string>{"ball 2: 2 shots"}));
  CHECK_EQUAL(3, e.blocks[0].of);
  CHECK_TRUE(e.outcome == Outcome::incomplete);
}

TEST(ProtocolEvaluation, AShotWhoseFlightWasNotFittedIsFiredAgain) {
  const auto p = protocol_of("repeats = 1\nreplacements = 1", "");
  auto shots = protocol_shots({{}, {}});
  shots[0].readout.flags.set(reduction::Flag::air_not_fitted);
  const auto e = protocol::evaluate(p, 0, shots);
  CHECK_TRUE(e.shots[0].use == Use::rejected && e.shots[1].use == Use::counts);
  CHECK_EQUAL(1, e.replaced);
}

TEST(ProtocolEvaluation, BallsMayHaveNames) {
  const auto p = protocol_of("repeats = 1\nballs = 3", "");
  const auto e = protocol::evaluate(p, 0, protocol_shots({{.ball = "red"}, {.ball = "3"}}));
  CHECK_TRUE((left(e) == std::vector<std::string>{"ball 2: 1 shot"}));
}

TEST(ProtocolEvaluation, MoreReplacementsThanAllowedEndTheTest) {
  const auto p = protocol_of("repeats = 1\nreplacements = 1", kConforming);
  const auto e = protocol::evaluate(p, 0, protocol_shots({{.mu = 0.7}, {.mu = 0.7}, {}}));
  CHECK_TRUE(e.out_of_replacements && e.outcome == Outcome::incomplete);
}

TEST(ProtocolEvaluation, TheDrawnOrderIsTheSeedsAndGoesOnWhereItWas) {
  const std::string test = "repeats = 2\nballs = 5\npositions = [\"a\", \"b\"]\norder = \"drawn\"";
  const auto p = protocol_of(test, "");
  const auto all = left(protocol::evaluate(p, 4, {}));
  CHECK_EQUAL(10U, all.size());
  CHECK_EQUAL(10U, std::set<std::string>(all.begin(), all.end()).size());
  CHECK_TRUE(std::ranges::all_of(all.begin(), all.begin() + 5, [](const auto& w) { return w.starts_with("position a, "); }));
  std::set<std::vector<std::string>> orders;
  for (std::uint64_t seed = 0; seed < 30; ++seed) orders.insert(left(protocol::evaluate(p, seed, {})));
  CHECK_TRUE(orders.size() > 20U);
  const protocol::Block first = protocol::evaluate(p, 4, {}).blocks[0];
  const auto rest = left(protocol::evaluate(
      p, 4, protocol_shots({{.position = "a", .ball = first.cell.ball}, {.position = "a", .ball = first.cell.ball}})));
  CHECK_TRUE((rest == std::vector<std::string>(all.begin() + 1, all.end())));
}

TEST(ProtocolEvaluation, GivesNoVerdictWithoutInputOrDocument) {
  const std::string more = "[[input]]\nname = \"temperature_c\"\nwords = \"temperature\"\nsd = 0.5\nleast = 10\nmost = 30\n" +
                           computed("x", "test", "mean(e) + 0*temperature_c") + requirement("x", "most = 1");
  const auto p = protocol_of("repeats = 1", more);
  auto shots = protocol_shots({{}});
  CHECK_TRUE(protocol::evaluate(p, 0, shots).outcome == Outcome::withheld);
  shots[0].readout.record["temperature_c"] = "21.5";
  CHECK_TRUE(protocol::evaluate(p, 0, shots).outcome == Outcome::pass);
  shots[0].readout.record["temperature_c"] = "35";
  CHECK_TRUE(protocol::evaluate(p, 0, shots).shots[0].use == Use::not_conforming);
  shots[0].readout.record["temperature_c"] = "21.5";
  protocol::Protocol unread = p;
  unread.source.read = protocol::SourceRead::not_read;
  CHECK_TRUE(protocol::evaluate(unread, 0, shots).outcome == Outcome::withheld);
}

// The scale leaves sd .01 of e = .8: .83 is three sds away (risk .135 %), .81 one.
TEST(ProtocolEvaluation, VerdictsFollowTheRule) {
  const auto of = [](const std::string& limits) {
    const auto p = protocol_of("repeats = 1", computed("x", "test", "mean(e)") + requirement("x", limits));
    return protocol::evaluate(p, 0, protocol_shots({{}})).verdicts.at(0);
  };
  CHECK_TRUE(of("most = 0.83").outcome == Outcome::pass);
  DOUBLES_EQUAL(0.001350, *of("most = 0.83").risk, 1e-6);
  CHECK_TRUE(of("most = 0.81").outcome == Outcome::inconclusive);
  CHECK_TRUE(of("most = 0.79\nrule = \"simple\"").outcome == Outcome::fail);
  CHECK_TRUE(of("most = 0.77").outcome == Outcome::fail);
  const std::string categories =
      "[[requirement.category]]\nname = \"low\"\nmost = 0.83\n[[requirement.category]]\nname = \"high\"\nleast = 0.83\n";
  CHECK_EQUAL(std::string("low"), of(categories).category);
  const auto near = of("[[requirement.category]]\nname = \"low\"\nmost = 0.81\n[[requirement.category]]\nname = \"high\"\nleast = 0.81\n");
  CHECK_TRUE(near.outcome == Outcome::inconclusive && near.category.empty());
}
