// Images in contact, against a motion that is known.
#include <cmath>

#include "common/units/angles.hpp"
#include "host/report/content/contact_points.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using lab_report::contact_points;
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
