// Frames of bounces and of single flights, drawn by rapidcheck over all that a frame may state, for properties that
// hold of any of them.
#pragma once

#include <array>
#include <numbers>

#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/simulated_shot.hpp"
#include "tests/support/property.hpp"

namespace strobe::test {

using reduction::Frame;

inline int whole(int least, int most) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(least, most + 1));
}

inline Bounce ordinary_bounce() {
  using testing::between;
  Bounce b;
  b.vx_td = between(3.0, 40.0), b.vy_td = between(-20.0, -3.0), b.omega_td = between(-400.0, 400.0);
  b.vx_lo = between(1.0, 30.0), b.vy_lo = between(2.0, 15.0), b.omega_lo = between(-400.0, 400.0);
  b.dwell_s = between(3e-3, 7e-3), b.dwell_x_m = between(0.01, 0.1);
  return b;
}

/// Some as steep as to have no direction of travel, some that graze or hardly rebound.
inline Bounce any_bounce() {
  using testing::between, testing::one_in, testing::over_decades;
  Bounce b = ordinary_bounce();
  if (one_in(4)) b.vx_td = between(-1.0, 1.0), b.vx_lo = between(-3.0, 3.0), b.dwell_x_m = between(-0.01, 0.01);
  if (one_in(8)) b.vy_td = -over_decades(0.1, 3.0);
  if (one_in(8)) b.vy_lo = over_decades(0.1, 2.0);
  return b;
}

inline Setup in_vacuum() {
  using testing::between;
  Setup s;
  s.air = {.drag_coefficient = 0.0, .lift = false, .spin_decay_per_m = 0.0};
  s.phase = between(0.06, 0.94);  // with the jitter below no image slips past touchdown or lift-off
  s.roll_rad = between(-0.3, 0.3);
  s.incoming = whole(2, 8);
  s.rebound = whole(2, 8);
  s.incline_rad = between(-0.5, 0.5);
  s.flash_jitter_s = between(0.0, 3e-5);
  return s;
}

inline Setup any_setup() {
  using testing::between, testing::one_in;
  Setup s = in_vacuum();
  if (one_in(2)) s.air = Air{};
  s.mirror = one_in(3);
  s.labels = !one_in(5);
  s.state_noise = !one_in(4);
  s.surface_x_m.clear();
  const int points = whole(2, 6);
  for (int i = 0; i < points; ++i) s.surface_x_m.push_back(0.6 * (i + between(0.2, 0.8)) / points - 0.3);
  return s;
}

inline Random any_random() { return Random(*rc::gen::arbitrary<std::uint64_t>()); }

/// What a calibration leaves open: the tilt of the camera, and the scale's growth along x.
inline void add_map_errors(Frame& frame) {
  for (const double slope : {0.0, 2e-4}) {
    reduction::MapError error;
    const auto shift = [&](const reduction::PointPx& p) {
      return slope == 0.0 ? reduction::PointPx{-2e-3 * p.y, 2e-3 * p.x} : reduction::PointPx{slope * p.x, 0.0};
    };
    for (const reduction::BallImage& image : frame.images)
      error.images.push_back({shift(image.centre_px), slope * image.diameter_px, slope == 0.0 ? 2e-3 : 0.0});
    for (const reduction::PointPx& p : frame.surface_px) error.surface_px.push_back(shift(p));
    frame.map_errors.push_back(std::move(error));
  }
}

/// What else may be stated of it, each some times.
inline void add_statements(Frame& frame, double px_per_m) {
  using testing::between, testing::one_in, testing::over_decades;
  frame.temperature_c = between(5.0, 35.0);
  frame.air_density_kgpm3 = between(1.1, 1.3);
  frame.ball_mass_kg = 0.0576;
  if (one_in(3)) frame.px_per_m = px_per_m, frame.px_per_m_sd = px_per_m * over_decades(1e-3, 1e-2);
  if (one_in(3)) frame.ball_diameter_sd_m = over_decades(1e-4, 1e-3);
  if (one_in(3)) add_map_errors(frame);
  if (one_in(3)) frame.shared_diameter_sd_px = px_per_m * over_decades(1e-5, 1e-4);
  const bool times_err = one_in(5), of_each = one_in(5), unread = one_in(5);
  for (reduction::BallImage& image : frame.images) {
    if (times_err) image.time_sd_s = 2e-6;
    if (unread && one_in(3)) image.equator_rad.reset();
    if (!of_each) continue;
    const double x = px_per_m * between(0.3e-3, 1e-3), y = px_per_m * between(0.3e-3, 1e-3);
    const double both = between(-0.9, 0.9) * x * y;
    image.centre_cov_px2 = {x * x, both, both, y * y};
    image.diameter_sd_px = px_per_m * between(0.3e-3, 1e-3);
    image.equator_sd_rad = between(0.01, 0.03);
  }
}

inline Frame any_frame() {
  const Bounce b = any_bounce();
  const Setup s = any_setup();
  Random random = any_random();
  Frame frame = photograph(b, s, random);
  add_statements(frame, s.px_per_m);
  return frame;
}

/// Without a surface.
inline Frame any_flight() {
  using testing::between;
  Bounce b;
  const double speed = between(3.0, 40.0), angle = between(-89.0, 89.0) * std::numbers::pi / 180.0;
  b.vx_td = speed * std::cos(angle), b.vy_td = speed * std::sin(angle), b.omega_td = between(-300.0, 300.0);
  Setup s = any_setup();
  s.labels = false;
  s.roll_rad = 0.01 * between(-1.0, 1.0);
  s.incoming = whole(4, 9);
  Random random = any_random();
  Frame frame = flight_alone(b, s, random);
  add_statements(frame, s.px_per_m);
  return frame;
}

}  // namespace strobe::test
