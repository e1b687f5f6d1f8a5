#include "tests/studies/digitize/crowded.hpp"

#include <algorithm>
#include <cmath>

#include "common/units/angles.hpp"
#include "sim/loading/load_scene.hpp"

namespace strobe::studies::digitize {

namespace {

constexpr double kStep_diameters = 0.8;

void set_scale(sim::CameraSettings& camera, double px_per_m) {
  camera.origin_x_px *= px_per_m / camera.px_per_m;
  camera.origin_y_px *= px_per_m / camera.px_per_m;
  camera.px_per_m = px_per_m;
}

/// With the margins that the scene has.
void set_view(sim::CameraSettings& camera, double half_width_m, double height_m) {
  camera.origin_x_px += (half_width_m - camera.half_width_m) * camera.px_per_m;
  camera.half_width_m = half_width_m;
  camera.height_m = height_m;
}

void set_step(Take& take, double diameters) {
  take.scene.lamps.recharge_s = 0.0;
  take.shooting.period = from_seconds(diameters * take.scene.ball.diameter_m / take.scene.machine.speed_mps);
}

}  // namespace

void set_size(Take& take, double diameter_px) {
  set_scale(take.scene.camera, diameter_px / take.scene.ball.diameter_m);
}

void set_images(Take& take, double images) {
  constexpr double kPixels = 5e6, kMargin_m = 0.1;
  set_step(take, kStep_diameters);
  const double d = take.scene.ball.diameter_m, angle = std::abs(take.scene.machine.angle_rad);
  const double half_way_m = 0.5 * images * kStep_diameters * d;
  auto& camera = take.scene.camera;
  set_view(camera, half_way_m * std::cos(angle), half_way_m * std::sin(angle) + d);
  const double area_m2 = (2.0 * camera.half_width_m + kMargin_m) * (camera.height_m + kMargin_m);
  set_scale(camera, std::min(camera.px_per_m, std::sqrt(kPixels / area_m2)));
}

void set_overlap(Take& take, double step_of_diameter) {
  set_step(take, step_of_diameter);
  take.scene.photograph.exposure *= std::min(1.0, step_of_diameter);
}

void set_rolling(Take& take, double restitution) {
  auto& machine = take.scene.machine;
  machine.speed_mps = 5.0;
  machine.angle_rad = radians(-20.0);
  machine.angle_sd_rad = machine.speed_sd_mps = 0.0;
  auto& bounce = take.scene.bounce;
  bounce.e = restitution;
  bounce.e_sd = bounce.e_slope_spm = bounce.e_speed_mps = 0.0;
  bounce.count = 20;
  set_step(take, kStep_diameters);
  set_view(take.scene.camera, 6.0 * take.scene.ball.diameter_m, 3.0 * take.scene.ball.diameter_m);
}

void set_skimming(Take& take, double height_mm) {
  set_rolling(take, 0.5);
  const double half_m = take.scene.camera.half_width_m;
  take.scene.machine.angle_rad = -std::atan2(1e-3 * height_mm, half_m);
  // Hardly pressed at all.
  take.scene.bounce.dwell_s = 1e-3;
}

void set_bounces(Take& take, double bounces) {
  constexpr double kE = 0.8, kFirst_m = 0.64, kFirst_s = 0.42;  // of the first flight after a bounce
  take.scene = sim::load_scene("photo_bounces").value();
  take.scene.machine.speed_mps = 3.0;
  take.scene.bounce.e = kE;
  take.scene.bounce.e_speed_mps = 2.6;
  take.scene.bounce.count = static_cast<int>(bounces);
  const double flights = (1.0 - std::pow(kE, bounces - 1.0)) / (1.0 - kE);
  take.shooting.period = milliseconds(40);
  take.shooting.exposure = std::min<Duration>(std::chrono::seconds(2), from_seconds(2.0 * (kFirst_s * flights + 0.2)));
  const double half_m = kFirst_m * flights + 0.3;
  set_view(take.scene.camera, half_m, 0.35);
  // Nothing comes from further than that to the left.
  take.scene.camera.origin_x_px -= (half_m - 0.3) * take.scene.camera.px_per_m;
}

void set_second_ball(Take& take, double later_ms) {
  // More flashes than both balls' images.
  take.shooting.exposure = milliseconds(240);
  if (later_ms == 0.0) return;
  sim::Fault fault;
  fault.kind = sim::FaultKind::machine_double;
  fault.delay = from_seconds(1e-3 * later_ms);
  take.scene.faults.push_back(fault);
}

void set_ball_at_rest(Take& take, double at_diameters) {
  if (at_diameters != 0.0) take.look.ball_at_rest_m = at_diameters * take.scene.ball.diameter_m;
}

}  // namespace strobe::studies::digitize
