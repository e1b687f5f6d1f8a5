// Limits as they are asked for, and what is decided of a result near one.
#include <cmath>

#include "common/units/angles.hpp"
#include "host/report/conformity.hpp"
#include "host/report/contact_figures.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::report;
using strobe::reduction::Quantity;

namespace {

constexpr Limit kLimit{Quantity::e, 0.80, 0.90};

std::string judged(double value, std::optional<double> u, DecisionRule rule) {
  return std::string(name(judge(value, u, kLimit, rule)));
}

std::string refused(const char* text) { return strobe::testing::error_of(parse_limit(text)); }

}  // namespace

TEST_GROUP(Conformity){};

TEST(Conformity, GuardBandsAreAsWideAsTheExpandedUncertainty) {
  CHECK_EQUAL(std::string("conforms"), judged(0.85, 0.04, DecisionRule::guarded));
  CHECK_EQUAL(std::string("conforms"), judged(0.8201, 0.02, DecisionRule::guarded));
  CHECK_EQUAL(std::string("not decided"), judged(0.82, 0.021, DecisionRule::guarded));
  CHECK_EQUAL(std::string("not decided"), judged(0.79, 0.02, DecisionRule::guarded));
  CHECK_EQUAL(std::string("does not conform"), judged(0.79, 0.005, DecisionRule::guarded));
  CHECK_EQUAL(std::string("does not conform"), judged(0.93, 0.02, DecisionRule::guarded));
  CHECK_EQUAL(std::string("not decided"), judged(0.85, 0.2, DecisionRule::guarded));  // wider than the limits
}

TEST(Conformity, SimpleAcceptanceTakesTheLimitsThemselves) {
  CHECK_EQUAL(std::string("conforms"), judged(0.80, 0.05, DecisionRule::simple));
  CHECK_EQUAL(std::string("does not conform"), judged(0.799, 0.05, DecisionRule::simple));
}

TEST(Conformity, WithoutAnUncertaintyNothingIsDecided) {
  for (const DecisionRule rule : {DecisionRule::guarded, DecisionRule::simple}) {
    CHECK_EQUAL(std::string("not decided"), judged(0.85, std::nullopt, rule));
    CHECK_EQUAL(std::string("not decided"), judged(NAN, 0.01, rule));
  }
}

TEST(Conformity, LimitsAreReadOrNamedAsWrong) {
  const auto limit = parse_limit("e=0.80..0.90");
  CHECK(limit && limit->quantity == Quantity::e);
  DOUBLES_EQUAL(0.80, limit->low, 0.0);
  DOUBLES_EQUAL(0.90, limit->high, 0.0);
  CHECK(std::isinf(parse_limit("theta_in_deg=..-15")->low));
  DOUBLES_EQUAL(-17.5, parse_limit("theta_in_deg=-17.5..-15")->low, 0.0);
  CHECK(std::isinf(parse_limit("court_pace=30..")->high));
  STRCMP_CONTAINS("must be QUANTITY=LOW..HIGH", refused("e").c_str());
  STRCMP_CONTAINS("must be QUANTITY=LOW..HIGH", refused("e=1").c_str());
  STRCMP_CONTAINS("no such quantity; there are theta_in_deg", refused("speed=1..2").c_str());
  STRCMP_CONTAINS("least or a largest", refused("e=..").c_str());
  STRCMP_CONTAINS("\"nan\" is not a number", refused("e=nan..1").c_str());
  STRCMP_CONTAINS("\"x\" is not a number", refused("e=0..x").c_str());
  STRCMP_CONTAINS("above the largest", refused("e=2..1").c_str());
}

TEST(Conformity, CourtPaceHasACategoryWhereItsIntervalLiesInOne) {
  CHECK_EQUAL(std::string("medium"), std::string(pace_category(37.0, 2.0, DecisionRule::guarded)->name));
  POINTERS_EQUAL(nullptr, pace_category(39.0, 2.0, DecisionRule::guarded));
  CHECK_EQUAL(std::string("medium"), std::string(pace_category(39.0, 2.0, DecisionRule::simple)->name));
  CHECK_EQUAL(std::string("slow"), std::string(pace_category(-5.0, 2.0, DecisionRule::guarded)->name));
  CHECK_EQUAL(std::string("fast"), std::string(pace_category(60.0, 2.0, DecisionRule::guarded)->name));
  POINTERS_EQUAL(nullptr, pace_category(37.0, std::nullopt, DecisionRule::guarded));
}

// Images in contact, against a motion that is known.
using namespace strobe;
using report::contact_points;
using reduction::Quantity;

namespace {

constexpr double kPxPerM = 4000.0, kDiameter_m = 0.0651;
constexpr double kVx_mps = 15.0, kVy_mps = -6.0, kSpinIn_radps = 4.0, kSpinOut_radps = -300.0,
                 kDwell_s = 5e-3;

/// Since touchdown; the spin changes evenly in contact.
double rotation_rad(double t) {
  return t <= 0.0 ? kSpinIn_radps * t
                  : kSpinIn_radps * t + 0.5 * (kSpinOut_radps - kSpinIn_radps) * t * t / kDwell_s;
}

reduction::BallImage image(double t, bool mirrored) {
  const double sign = mirrored ? -1.0 : 1.0;
  const double x_m = 0.3 + kVx_mps * t, height_m = 0.5 * kDiameter_m + (t <= 0.0 ? kVy_mps * t : -0.004);
  reduction::BallImage out;
  out.time_s = t;
  out.leg = t <= 0.0 ? Leg::incoming : Leg::contact;
  out.centre_px = {sign * kPxPerM * x_m, kPxPerM * height_m};
  out.diameter_px = kPxPerM * kDiameter_m;
  out.equator_rad = std::remainder(sign * (0.7 + rotation_rad(t)), kPi);
  if (t > 0.0) out.top_px = reduction::PointPx{out.centre_px.x, kPxPerM * (kDiameter_m - 0.006)};
  return out;
}

reduction::Frame frame(bool mirrored) {
  reduction::Frame out;
  out.ball_diameter_m = kDiameter_m;
  out.px_per_m = kPxPerM;
  out.px_per_m_sd = 1.0;
  out.centre_sd_px = out.diameter_sd_px = 0.1;
  const double sign = mirrored ? -1.0 : 1.0;
  for (const double x : {0.0, 300.0, 2000.0, 2700.0}) out.surface_px.push_back({sign * x, 0.0});
  for (const double t : {-8e-3, -5e-3, -2e-3, 1e-3, 4e-3}) out.images.push_back(image(t, mirrored));
  return out;
}

reduction::Readout readout() {
  reduction::Readout out;
  out.value[Quantity::vx_td_mps] = kVx_mps;
  out.value[Quantity::vy_td_mps] = kVy_mps;
  out.value[Quantity::omega_td_radps] = kSpinIn_radps;
  out.value[Quantity::omega_lo_radps] = kSpinOut_radps;
  out.value[Quantity::dwell_time_ms] = 1e3 * kDwell_s;
  return out;
}

}  // namespace

TEST_GROUP(ContactPoints){};

TEST(ContactPoints, AreMeasuredFromTouchdown) {
  for (const bool mirrored : {false, true}) {
    const auto points = contact_points(frame(mirrored), readout());
    LONGS_EQUAL(2, points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double t = i == 0 ? 1e-3 : 4e-3;
      // Nothing is rounded but numbers: the path that leads to touchdown is the straight line that made the images.
      DOUBLES_EQUAL(t, points[i].time_s, 1e-9);
      DOUBLES_EQUAL(kVx_mps * t, points[i].x_m, 1e-9);
      DOUBLES_EQUAL(-0.006, points[i].drop_m, 1e-9);
      CHECK(points[i].rotation_rad.has_value());
      DOUBLES_EQUAL(rotation_rad(t), *points[i].rotation_rad, 1e-9);
    }
  }
}

TEST(ContactPoints, NeedAMotionATopAndTimes) {
  auto still = readout();
  still.value[Quantity::omega_lo_radps].reset();
  CHECK(contact_points(frame(false), still).empty());
  auto topless = frame(false);
  for (auto& each : topless.images) each.top_px.reset();
  CHECK(contact_points(topless, readout()).empty());
  auto timeless = frame(false);
  for (auto& each : timeless.images) each.time_s = 0.0;
  CHECK(contact_points(timeless, readout()).empty());
  CHECK(contact_points({}, readout()).empty());
}

TEST(ContactPoints, HaveNoRotationWithoutAnEquator) {
  auto plain = frame(false);
  plain.images[3].equator_rad.reset();
  const auto points = contact_points(plain, readout());
  LONGS_EQUAL(2, points.size());
  CHECK_FALSE(points[0].rotation_rad.has_value());
  CHECK(points[1].rotation_rad.has_value());
}
