// Which one thing explains what has changed, from changes written by hand.
#include <vector>

#include "host/series/drift.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;

namespace {

/// Changes in sds of all charts but the path's; gravity is told to 0.1 %.
std::vector<WitnessShift> changes(double gravity_percent, double diameters_percent, double surface_deg = 0.0,
                                  double lamp_a_us = 0.0, double lamp_b_us = 0.0, double clock_ppm = 0.0,
                                  double paths = 0.0) {
  return {{Witness::gravity_mps2, {9.81, 0.01}, {0.0981 * gravity_percent, 0.00981}},
          {Witness::diameters_px_per_m, {4000.0, 0.1}, {40.0 * diameters_percent, 0.2}},
          {Witness::surface_deg, {0.3, 0.001}, {surface_deg, 0.01}},
          {Witness::lamp_a_us, {12.0, 0.3}, {lamp_a_us, 0.5}},
          {Witness::lamp_b_us, {13.0, 0.3}, {lamp_b_us, 0.5}},
          {Witness::clock_ppm, {0.0, 50.0}, {clock_ppm, 50.0}},
          {Witness::path_residuals, {1.0, 0.1}, {paths, 0.1}}};
}

std::string named(const std::vector<WitnessShift>& shifts, bool calibrated = true) {
  std::string names;
  for (const Culprit c : culprits(shifts, calibrated)) names += (names.empty() ? "" : " ") + std::string(name(c));
  return names;
}

ShotWitnesses shot_of(double gravity_mps2, double px_per_m) {
  ShotWitnesses w;
  w.of[static_cast<std::size_t>(Witness::gravity_mps2)] = WitnessValue{{gravity_mps2, 0.02}, {}};
  w.of[static_cast<std::size_t>(Witness::diameters_px_per_m)] = WitnessValue{{px_per_m, 1.0}, {}};
  w.calibrated = true;
  return w;
}

}  // namespace

TEST_GROUP(Drift){};

TEST(Drift, IsTheScaleWhereGravityGrowsWithTheBalls) { STRCMP_EQUAL("scale", named(changes(1.0, 1.0)).c_str()); }

TEST(Drift, IsTheBallWhereGravityStays) {
  STRCMP_EQUAL("ball", named(changes(0.0, 1.0)).c_str());
  STRCMP_EQUAL("ball", named(changes(-1.0, 1.0), false).c_str());
  STRCMP_EQUAL("scale", named(changes(0.0, 1.0), false).c_str());
}

TEST(Drift, IsTheClockWhereGravityFallsByTwice) {
  STRCMP_EQUAL("clock", named(changes(-0.6, 0.0, 0.0, 0.0, 0.0, -3000.0)).c_str());
}

TEST(Drift, IsTheTiltOrALampWhereNothingElseMoves) {
  STRCMP_EQUAL("tilt", named(changes(0.0, 0.0, 0.5)).c_str());
  STRCMP_EQUAL("lamp_a", named(changes(0.0, 0.0, 0.0, 10.0)).c_str());
  STRCMP_EQUAL("lamp_b", named(changes(0.0, 0.0, 0.0, 0.0, 10.0)).c_str());
}

TEST(Drift, IsTheAirWhereGravityAloneMoves) { STRCMP_EQUAL("air", named(changes(-2.0, 0.0)).c_str()); }

TEST(Drift, IsTheLensWherePathsBend) {
  STRCMP_EQUAL("lens", named(changes(-2.0, 0.5, 0.0, 0.0, 0.0, 0.0, 3.0)).c_str());
}

TEST(Drift, IsLeftOpenWhereGravityIsNotKnownWellEnough) {
  auto coarse = changes(0.2, 0.3);
  coarse[0].change.sd = 0.3;
  STRCMP_EQUAL("scale ball", named(coarse).c_str());
}

TEST(Drift, HasNoCulpritWhereTwoThingsChanged) {
  STRCMP_EQUAL("", named(changes(0.0, 0.0, 0.5, 10.0)).c_str());
}

TEST(Drift, AlarmNamesTheShotAndTheFirstOfTheChange) {
  WitnessCharts charts;
  for (int i = 1; i <= 30; ++i) {
    const double wiggle = i % 2 == 0 ? 1.0 : -1.0;
    const bool off = i > 21;
    const auto alarms = charts.add(std::to_string(i), shot_of(9.81 + 0.02 * wiggle, (off ? 4012.0 : 4000.0) + wiggle));
    CHECK_TRUE(alarms.empty() || off);
  }
  const auto verdict = charts.verdict();
  CHECK_TRUE(verdict.has_value());
  CHECK_EQUAL(1U, verdict->alarms.size());
  STRCMP_EQUAL("22", verdict->alarms[0].since.c_str());
  CHECK_TRUE(verdict->alarms[0].chart == Witness::diameters_px_per_m);
  // Nine shots of 1 px/m that alternate, 21 before: a seventh; twice that.
  CHECK_EQUAL(2U, verdict->shifts.size());
  DOUBLES_EQUAL(12.0, verdict->shifts[1].change.value, 0.3);
}
