#include "sim/plan/nominal_shot.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/rig/camera.hpp"
#include "sim/rig/tablet.hpp"
#include "sim/scene/reduced_scene.hpp"
#include "sim/shoot/window.hpp"

namespace strobe::sim {

namespace {

constexpr MonoTime kTouchdown = from_ns(1'000'000'000'000);
constexpr double kLongest_s = 2.0;

}  // namespace

Train train_of(const Scene& scene, const ShootSettings& settings) {
  const double period_s = to_seconds(settings.period);
  const double half_s = 0.5 * to_seconds(settings.exposure);
  if (half_s > 0.0) return {period_s, half_s, half_s};
  const Window window = crossing_window(scene, period_s);
  return {period_s, window.before_s, window.after_s};
}

ModelledScene::ModelledScene(const Scene& scene, const Model& only)
    : whole(scene), left(reduced_scene(scene, only)), model(only) {
  if (!needs_calibration(left, model)) return;
  if (const auto constants = calibrate(left, model)) reduced = *constants;
}

NominalShot::NominalShot(const Scene& scene, BallPath path)
    : scene_(scene),
      path_(std::move(path)),
      first_seen_s_(seen_until_s(-1.0)),
      last_seen_s_(seen_until_s(1.0)) {}

std::optional<NominalShot> NominalShot::make(const ModelledScene& scene, const Corner& corner) {
  const ReducedContact* reduced = scene.reduced ? &*scene.reduced : nullptr;
  auto path = BallPath::make(scene.left, shot_conditions_at(scene.whole, corner), scene.model, reduced);
  if (!path) return std::nullopt;
  return NominalShot(scene.left, std::move(*path));
}

/// A ball may rise out of the view and fall into it again: the way along the surface decides.
double NominalShot::seen_until_s(double direction) const {
  const double reach_m = 1.2 * scene_.camera.half_width_m + std::abs(path_.spot_m());
  const LegMotion leg = direction < 0.0 ? incoming() : rebound();
  const double ends_s = direction < 0.0 ? 0.0 : dwell_s();
  double t = reach_m / std::hypot(leg.vx_mps, leg.vy_mps);
  while (t < kLongest_s && std::abs(path_.at(ends_s + direction * t).x_m) <= reach_m) t *= 1.25;
  return ends_s + direction * t;
}

NominalFrame NominalShot::photograph(std::span<const NominalFlash> flashes) const {
  Exposure exposure;
  exposure.shot = 1;
  exposure.ball = ThrownBall{path_, kTouchdown};
  exposure.opened = kTouchdown + from_seconds(-2.0 * kLongest_s);
  exposure.closed = kTouchdown + from_seconds(2.0 * kLongest_s);
  for (const NominalFlash& flash : flashes) {
    const MonoTime at = kTouchdown + from_seconds(flash.time_s);
    Pulse pulse;
    pulse.edge = at;
    pulse.flashes.push_back(at);
    pulse.stamps.push_back(at + from_seconds(flash.stamp_late_s));
    exposure.pulses.push_back(pulse);
  }
  Digitized digitized = digitize_perfectly(scene_, 1, exposure);
  NominalFrame result{std::move(digitized.frame), {}};
  for (std::size_t i = 0; i < result.frame.images.size(); ++i) {
    result.frame.images[i].time_s = to_seconds(digitized.image_stamp[i] - digitized.image_stamp[0]);
    result.flash.push_back(static_cast<std::size_t>(digitized.image_pulse[i]));
  }
  return result;
}

std::vector<NominalFlash> NominalShot::flashes(const Train& train, double phase, double late_s) const {
  const double first = std::max(first_seen_s_, -train.before_s - late_s);
  const double last = std::min(last_seen_s_, train.after_s - late_s);
  std::vector<NominalFlash> all;
  for (double k = std::floor(first / train.period_s); (k + phase) * train.period_s <= last; ++k) {
    const double t = (k + phase) * train.period_s;
    if (t >= first) all.push_back({t, 0.0});
  }
  return all;
}

NominalShot::Seen NominalShot::flattening_seen() const {
  const double middle_s = 0.5 * dwell_s();
  const auto seen = [&](double t) { return path_.at(t).top_drop_m > scene_.tablet.visible_flattening_m; };
  if (!seen(middle_s)) return {middle_s, middle_s};
  const auto edge = [&](double unseen_s) {
    double seen_s = middle_s;
    for (int i = 0; i < 30; ++i) {
      const double half = 0.5 * (seen_s + unseen_s);
      (seen(half) ? seen_s : unseen_s) = half;
    }
    return unseen_s;
  };
  return {edge(0.0), edge(dwell_s())};
}

LegMotion NominalShot::incoming() const {
  const impact::Motion& m = path_.touchdown();
  return {m.vx_mps, m.vy_mps, m.omega_radps};
}

LegMotion NominalShot::rebound() const {
  const impact::Motion& m = path_.rebound().lift_off;
  return {m.vx_mps, m.vy_mps, m.omega_radps};
}

}  // namespace strobe::sim
