#include "tests/host/synthetic_shot.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace strobe::host_test {
namespace {

using strobe_msgs::ball_image_t;
using strobe_msgs::flash_t;
using strobe_msgs::shot_t;

constexpr double kPxPerM = 4000.0;
constexpr double kRoll = 0.3 * std::numbers::pi / 180.0;
constexpr double kRadius_m = kBallDiameter_m / 2;
constexpr double kG = 9.80665;
constexpr std::int64_t kFirstFlash_ns = 5'000'000'000'000;
constexpr double kLampDelay_us = 12.0;

struct Pose {
  double x, y, angle;
  std::int8_t leg;
};

struct State {
  double x, y, vx, vy;
};

/// Gravity, drag with C_D = 0.55 and Magnus lift with C_L = R omega / (2 R |omega| + v), of 57.6 g in air of
/// 1.204 kg/m3.
State rate(const State& s, double omega) {
  constexpr double kPerM = 1.204 * std::numbers::pi * kRadius_m * kRadius_m / (2 * 0.0576);
  const double speed = std::hypot(s.vx, s.vy), drag = kPerM * 0.55 * speed;
  const double lift = kPerM * kRadius_m * omega / (2 * kRadius_m * std::abs(omega) + speed) * speed;
  return {s.vx, s.vy, -drag * s.vx - lift * s.vy, -kG - drag * s.vy + lift * s.vx};
}

/// A time t after (or, negative, before) `from`: sixteen steps of Runge and Kutta's fourth order.
State flown(const State& from, double omega, double t) {
  constexpr int kSteps = 16;
  const double h = t / kSteps;
  const auto moved = [](const State& s, double by, const State& d) {
    return State{s.x + by * d.x, s.y + by * d.y, s.vx + by * d.vx, s.vy + by * d.vy};
  };
  State s = from;
  for (int i = 0; i < kSteps; ++i) {
    const State a = rate(s, omega);
    const State b = rate(moved(s, h / 2, a), omega);
    const State c = rate(moved(s, h / 2, b), omega);
    const State d = rate(moved(s, h, c), omega);
    s = moved(moved(moved(moved(s, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
  }
  return s;
}

Pose pose_at(const Bounce& b, double t) {  // t after touchdown
  if (t < 0) {
    const State at = flown({0.0, kRadius_m, b.vx_td, b.vy_td}, b.omega_td, t);
    return {at.x, at.y, 0.4 + b.omega_td * t, ball_image_t::LEG_INCOMING};
  }
  if (t > b.dwell_s) {
    const double s = t - b.dwell_s;
    const double turned = 0.4 + (b.omega_td + b.omega_lo) / 2 * b.dwell_s;
    const State at = flown({b.distance_m, kRadius_m, b.vx_lo, b.vy_lo}, b.omega_lo, s);
    return {at.x, at.y, turned + b.omega_lo * s, ball_image_t::LEG_REBOUND};
  }
  // Friction early in the contact: the speed along the surface falls as a power law that covers the distance.
  const double s = t / b.dwell_s;
  const double mean = b.distance_m / b.dwell_s;
  const double share = (mean - b.vx_lo) / (b.vx_td - b.vx_lo);
  const double power = std::max(0.2, 1 / std::max(share, 1e-3) - 1);
  const double x =
      b.vx_lo * t + (b.vx_td - b.vx_lo) * b.dwell_s * (1 - std::pow(1 - s, power + 1)) / (power + 1);
  const double y = kRadius_m - 0.25 * -b.vy_td * b.dwell_s * std::sin(std::numbers::pi * s);
  return {x, y, 0.4 + (b.omega_td + b.omega_lo) / 2 * t, ball_image_t::LEG_CONTACT};
}

flash_t make_flash(const Scenario& sc, int k, double* light_s) {
  flash_t flash{};
  flash.lamps = 3;
  const auto planned_ns = static_cast<std::int64_t>(std::llround(flash_offset_s(sc, k) * 1e9));
  const auto late = sc.late_us.find(k);
  const double late_us = late == sc.late_us.end() ? 0.0 : late->second;
  flash.flash_index = k;
  flash.commanded_ns = kFirstFlash_ns + planned_ns;
  flash.issue_start_ns = flash.commanded_ns - 50;
  flash.issue_end_ns = flash.commanded_ns + 60;
  const auto light_ns = flash.commanded_ns + std::llround((kLampDelay_us + late_us) * 1e3);
  *light_s = static_cast<double>(light_ns - kFirstFlash_ns) * 1e-9;
  const bool dark = sc.missing.contains(k);
  flash.observed_a_ns = dark || !sc.sensor_a ? flash_t::NO_TIME : light_ns + 700;
  flash.observed_b_ns = dark || !sc.sensor_b ? flash_t::NO_TIME : light_ns - 700;
  flash.extra_edges = sc.doubled.contains(k) ? 2 : 0;
  return flash;
}

ball_image_t make_image(const Scenario& sc, const Pose& pose, std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, sc.noise_mm * 1e-3 * kPxPerM);
  std::normal_distribution<double> turn(0.0, sc.equator_noise_rad);
  const double towards = sc.leftwards ? -1.0 : 1.0;
  const double x = towards * pose.x * kPxPerM, y = pose.y * kPxPerM;
  ball_image_t image{};
  image.leg = sc.legs_named ? pose.leg : ball_image_t::LEG_UNKNOWN;
  image.centre_x_px = 2500 + x * std::cos(kRoll) - y * std::sin(kRoll) + noise(random);
  image.centre_y_px = 300 + x * std::sin(kRoll) + y * std::cos(kRoll) + noise(random);
  image.diameter_px = kBallDiameter_m * kPxPerM + noise(random);
  image.equator_rad = std::remainder(towards * pose.angle + kRoll + turn(random), std::numbers::pi);
  image.top_x_px = image.top_y_px = image.contact_width_px = std::numeric_limits<double>::quiet_NaN();
  image.centre_xx_px2 = image.centre_xy_px2 = image.centre_yy_px2 = std::numeric_limits<double>::quiet_NaN();
  image.diameter_sd_px = image.equator_sd_rad = std::numeric_limits<double>::quiet_NaN();
  image.equator_tilt_rad = image.equator_tilt_sd_rad = image.equator_tilt_correlation = image.probability =
      std::numeric_limits<double>::quiet_NaN();
  return image;
}

void describe_frame(const Scenario& sc, SyntheticShot& made) {
  auto& frame = made.frame;
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  frame.schema_version = strobe_msgs::frame_t::SCHEMA_VERSION;
  frame.boot_id = made.shot.boot_id;
  frame.shot_id = made.shot.shot_id;
  frame.source = "hand";
  frame.centre_sd_px = sc.noise_stated ? sc.noise_mm * 1e-3 * kPxPerM : unknown;
  frame.diameter_sd_px = frame.centre_sd_px;
  frame.shared_diameter_sd_px = unknown;
  frame.surface_sd_px = unknown;
  frame.equator_sd_rad = sc.noise_stated ? sc.equator_noise_rad : unknown;
  frame.px_per_m = frame.px_per_m_sd = unknown;
  for (const double x : {-900.0, -600.0, 600.0, 900.0}) {
    strobe_msgs::point_t point;
    point.x_px = 2500 + x * std::cos(kRoll);
    point.y_px = 300 + x * std::sin(kRoll);
    frame.surface.push_back(point);
  }
  frame.surface_count = 4;
  frame.image_count = static_cast<std::int32_t>(frame.images.size());
}

}  // namespace

int last_flash_before_touchdown(const Scenario& sc) {
  return static_cast<int>(std::floor((sc.touchdown_s - kLampDelay_us * 1e-6) / sc.period_s));
}

double flash_offset_s(const Scenario& sc, int k) {
  double offset_s = 0.0;
  for (int slot = 0, flash = 0;; ++slot) {
    if (!sc.omitted.contains(slot) && flash++ == k) return offset_s;
    offset_s += sc.intervals_s.empty()
                    ? sc.period_s
                    : sc.intervals_s[static_cast<std::size_t>(slot) % sc.intervals_s.size()];
  }
}

/// The train as it was ordered.
static void put_code(shot_t& shot) {
  for (const auto& flash : shot.flashes) {
    shot.plan.code.emplace_back();
    shot.plan.code.back().offset_ns = flash.commanded_ns - kFirstFlash_ns;
    shot.plan.code.back().lamps = strobe_msgs::coded_flash_t::BOTH_LAMPS;
  }
  shot.plan.code_count = shot.flash_count;
}

SyntheticShot make_shot(const Scenario& sc) {
  std::mt19937 random(sc.seed);
  SyntheticShot made{};
  shot_t& shot = made.shot;
  shot.schema_version = shot_t::SCHEMA_VERSION;
  shot.boot_id = 77;
  shot.shot_id = 1;
  shot.host_id = 5;
  shot.plan.period_ns = std::llround(sc.period_s * 1e9);
  shot.start_ns = kFirstFlash_ns - 100'000'000;
  shot.shutter_open_ns = kFirstFlash_ns;
  shot.shutter_close_ns = kFirstFlash_ns + std::llround(sc.flash_count * sc.period_s * 1e9);
  shot.trigger_ns =
      kFirstFlash_ns + std::llround((sc.touchdown_s - kMachineLag_s - sc.machine_error_s) * 1e9);
  shot.gate_ns = shot_t::NO_TIME;
  shot.shutter_on_ns = shot.shutter_off_ns = shot_t::NO_TIME;
  shot.lamp_delay_a_us = shot.lamp_delay_b_us = kLampDelay_us;
  shot.sensor_a_fitted = shot.sensor_b_fitted = true;
  shot.late_tolerance_us = 100;
  for (int k = 0; k < sc.flash_count; ++k) {
    double light_s = 0.0;
    shot.flashes.push_back(make_flash(sc, k, &light_s));
    const Pose pose = pose_at(sc.bounce, light_s - sc.touchdown_s);
    const bool in_view =
        pose.x > -sc.view_before_m && pose.x < sc.bounce.distance_m + sc.view_after_m && pose.y < 0.4;
    if (!in_view || sc.missing.contains(k) || sc.unseen.contains(k)) continue;
    made.frame.images.push_back(make_image(sc, pose, random));
    made.image_flash.push_back(k);
  }
  shot.flash_count = sc.flash_count;
  if (!sc.intervals_s.empty() || !sc.omitted.empty()) put_code(shot);
  describe_frame(sc, made);
  return made;
}

}  // namespace strobe::host_test
