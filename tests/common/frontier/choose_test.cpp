#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "common/frontier/frontier.hpp"
#include "common/units/tolerance.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::frontier;

namespace {

Row row(std::string method, double cost_us, double error, std::string parameter = "") {
  return {.study = "lift_off",
          .method = std::move(method),
          .parameter = std::move(parameter),
          .cost_us = cost_us,
          .error = error,
          .error_unit = "of v_td",
          .note = ""};
}

const std::vector<Row> kRows{row("rigid", 0.01, 0.1), row("grip", 0.02, 0.04),
                             row("ode", 9.0, 4e-4, "tolerance=0.001"), row("euler", 30.0, 2e-3, "steps=200"),
                             row("ode", 20.0, 1e-7, "tolerance=1e-06")};

bool dominates(const Row& a, const Row& b) {
  return a.cost_us <= b.cost_us && a.error <= b.error && (a.cost_us < b.cost_us || a.error < b.error);
}

/// A few levels only, so that equals and ends of ranges come up.
struct Draw {
  std::mt19937_64 random;
  double level() { return std::uniform_int_distribution<int>(1, 6)(random); }
  bool often() { return std::uniform_int_distribution<int>(0, 3)(random) != 0; }
  std::vector<Row> rows() {
    std::vector<Row> all;
    const int count = std::uniform_int_distribution<int>(0, 7)(random);
    for (int i = 0; i < count; ++i) all.push_back(row("ode", level(), level(), std::to_string(i)));
    return all;
  }
  Requirement requirement() {
    Requirement d;
    if (often()) d.tolerance = level() + 0.5 * (often() ? 0 : 1);
    if (often()) d.deadline_us = level();
    return d;
  }
};

}  // namespace

TEST_GROUP(Choose){};

TEST(Choose, TakesTheCheapestThatIsExactEnough) {
  CHECK_EQUAL("rigid", label(*choose(kRows, {.tolerance = 0.1, .deadline_us = {}})));
  CHECK_EQUAL("grip", label(*choose(kRows, {.tolerance = 0.05, .deadline_us = {}})));
  CHECK_EQUAL("ode tolerance=0.001", label(*choose(kRows, {.tolerance = 0.01, .deadline_us = 50.0})));
}

TEST(Choose, TakesTheMostExactInTimeWithoutATolerance) {
  CHECK_EQUAL("ode tolerance=0.001", label(*choose(kRows, {.tolerance = {}, .deadline_us = 10.0})));
  CHECK_EQUAL("ode tolerance=1e-06", label(*choose(kRows, {})));
}

TEST(Choose, RefusesNamingWhatComesNearest) {
  const Requirement requirement{.tolerance = 1e-3, .deadline_us = 5.0};
  const auto refused = choose(kRows, requirement);
  CHECK(!refused);
  CHECK_EQUAL(
      "no method meets 0.1% and 5 us; in time the most exact is grip (4% of v_td in 0.02 us); exact enough "
      "the "
      "fastest is ode tolerance=0.001 (0.04% of v_td in 9 us)",
      failure_text(refused.error(), requirement));
}

TEST(Choose, RefusesNamingTheFastestAndTheMostExactWhereNothingComesNear) {
  const Requirement requirement{.tolerance = 1e-9, .deadline_us = 1e-3};
  CHECK_EQUAL(
      "no method meets 1e-7% and 0.001 us; the fastest of all is rigid (10% of v_td in 0.01 us); the most "
      "exact "
      "of all is ode tolerance=1e-06 (1e-05% of v_td in 20 us)",
      failure_text(choose(kRows, requirement).error(), requirement));
  CHECK_EQUAL("the frontier holds no method that could be taken",
              failure_text(choose({}, requirement).error(), requirement));
}

TEST(Choose, SaysWhy) {
  CHECK_EQUAL("the cheapest of 5 methods that meets 0.1% and 50 us",
              reason(kRows, {.tolerance = 1e-3, .deadline_us = 50.0}));
  CHECK_EQUAL("the most exact of 5 methods that meets 50 us",
              reason(kRows, {.tolerance = {}, .deadline_us = 50.0}));
}

TEST(Choose, IsNeverDominatedNeverMissesAndRefusesOnlyWhereNothingMeetsBoth) {
  constexpr std::uint64_t kSeed = 4;
  Draw draw{std::mt19937_64(kSeed)};
  int refused = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::vector<Row> rows = draw.rows();
    const Requirement requirement = draw.requirement();
    const auto meets = [&](const Row& r) {
      return (!requirement.tolerance || r.error <= *requirement.tolerance) &&
             (!requirement.deadline_us || r.cost_us <= *requirement.deadline_us);
    };
    const auto chosen = choose(rows, requirement);
    CHECK_EQUAL(std::ranges::any_of(rows, meets), chosen.has_value());
    if (!chosen) {
      ++refused;
      continue;
    }
    CHECK(meets(*chosen));
    for (const Row& other : rows) {
      CHECK(!dominates(other, *chosen));
      if (!meets(other)) continue;
      if (requirement.tolerance) CHECK(chosen->cost_us <= other.cost_us);
      if (!requirement.tolerance) CHECK(chosen->error <= other.error);
    }
  }
  CHECK(refused > 1000);
}

TEST(Choose, TheNearestMeetOneDemandAndAreTheBestInTheOther) {
  constexpr std::uint64_t kSeed = 5;
  Draw draw{std::mt19937_64(kSeed)};
  for (int i = 0; i < 20000; ++i) {
    const std::vector<Row> rows = draw.rows();
    const Requirement requirement{.tolerance = draw.level() - 1.0, .deadline_us = draw.level() - 0.5};
    const auto chosen = choose(rows, requirement);
    if (chosen) continue;
    const NearestMethods& nearest = chosen.error();
    for (const Row& r : rows) {
      if (requirement.meets_deadline(r))
        CHECK(nearest.most_accurate_in_time && nearest.most_accurate_in_time->error <= r.error);
      if (requirement.meets_tolerance(r))
        CHECK(nearest.fastest_accurate_enough && nearest.fastest_accurate_enough->cost_us <= r.cost_us);
    }
    if (nearest.most_accurate_in_time) CHECK(requirement.meets_deadline(*nearest.most_accurate_in_time));
    if (nearest.fastest_accurate_enough) CHECK(requirement.meets_tolerance(*nearest.fastest_accurate_enough));
  }
}
