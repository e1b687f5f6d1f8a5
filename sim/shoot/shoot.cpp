#include "sim/shoot/shoot.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sim/motion/ball_path.hpp"
#include "sim/random/draws.hpp"
#include "sim/rig/camera.hpp"
#include "sim/rig/tablet.hpp"
#include "sim/rig/truth.hpp"

namespace strobe::sim {

namespace {

constexpr MonoTime kStart = from_ns(1'000'000'000'000);
constexpr Duration kLinePulse = microseconds(50);
constexpr Duration kLongestFlight = milliseconds(4000);
constexpr Duration kLead = milliseconds(1);

void set(SimulatedShot& shot, ShotFlag flag) { shot.flags.set(static_cast<std::size_t>(flag)); }

constexpr double kLongest_s = 0.25;
constexpr double kStep_s = 1e-3;

double seen_for_s(const Camera& camera, const BallPath& path, double step_s) {
  double t = 0.0;
  while (std::abs(t) < kLongest_s) {
    const BallState s = path.at(t);
    if (path.beyond_last_bounce(t, s) || !camera.sees(s.x_m, s.y_m)) break;
    t += step_s;
  }
  return std::abs(t);
}

/// Around the instant at which the mean ball meets the plate. [s]
struct Window {
  double before_s = 0.0;
  double after_s = 0.0;
};

/// How long the balls of a scene are in the camera's view: from its mean ball, with margins for the spread of
/// speed, angle and the machine's lag at kLargestNormal standard deviations, and a flash's period on either
/// side. Each side at most 0.25 s before lag and period are added. A ball that comes back into view, falling,
/// is not waited for.
Window crossing_window(const Scene& scene, double period_s) {
  const Scene mean = without_spread(scene);
  const auto path = BallPath::make(mean, draw_shot_conditions(mean, 1, 1));
  const Camera camera(mean);
  const double before = path ? seen_for_s(camera, *path, -kStep_s) : kLongest_s;
  const double after = path ? seen_for_s(camera, *path, kStep_s) : kLongest_s;
  const MachineSettings& m = scene.machine;
  const double slowest = std::max(0.2, 1.0 - kLargestNormal * m.speed_sd_mps / m.speed_mps -
                                           kLargestNormal * m.angle_sd_rad * std::tan(std::abs(m.angle_rad)));
  const double wait = kLargestNormal * m.lag_sd_s + period_s;
  return {std::min(before / slowest, kLongest_s) + wait, std::min(after / slowest, kLongest_s) + wait};
}

}  // namespace

Shooter::Shooter(const Scene& scene, std::uint64_t seed, const Model& model, const ShootSettings& settings)
    : settings_(settings), rig_(std::make_unique<Rig>(scene, seed, kStart, model)) {
  rig_->watch_gate(false);
  // From the scene as it is, so that every model of it has the same train.
  const Window window = settings.exposure > Duration{}
                            ? Window{0.5 * to_seconds(settings.exposure), 0.5 * to_seconds(settings.exposure)}
                            : crossing_window(scene, to_seconds(settings.period));
  before_ = from_seconds(window.before_s);
  flashes_ = static_cast<int>((before_ + from_seconds(window.after_s)) / settings.period) + 1;
  if (!settings.train.empty()) {
    before_ = settings.train.back() / 2;
    flashes_ = static_cast<int>(settings.train.size());
  }
  open_ahead_ = from_seconds(scene.shutter.open_lag_s + kLargestNormal * scene.shutter.lag_sd_s) + kLead;
}

Result<Shooter> Shooter::make(const Scene& scene, std::uint64_t seed, const Model& model,
                              const ShootSettings& settings) {
  if (settings.period < microseconds(100) || settings.period > milliseconds(1000))
    return fail("period: must be 0.1…1000 ms");
  if (settings.exposure < Duration{} || settings.exposure > milliseconds(2000))
    return fail("exposure: must be 0…2 s");
  if (const auto refusal = refusal_in_space(scene, model); refusal && !scene.machine.planar())
    return fail("model: " + *refusal);
  if (!std::ranges::is_sorted(settings.train)) return fail("train: must ascend");
  return Shooter(scene, seed, model, settings);
}

Duration Shooter::offset(int flash) const {
  return settings_.train.empty() ? settings_.period * flash
                                 : settings_.train[static_cast<std::size_t>(flash)];
}

void Shooter::play(int shot) {
  drives_.clear();
  exposures_.clear();
  rig_->restart(shot, kStart);
  const MonoTime first = kStart + milliseconds(10'000);
  const MonoTime trigger = first + before_ - from_seconds(scene().machine.lag_s);
  const MonoTime last = first + offset(flashes_ - 1);
  bool triggered = false;
  const auto change = [&](RigLine line, int level, MonoTime at) {
    if (!triggered && trigger <= at) {
      triggered = true;
      rig_->line_changed(RigLine::trigger, 1, trigger);
      rig_->line_changed(RigLine::trigger, 0, trigger);
    }
    rig_->line_changed(line, level, at);
  };
  // A ball that was thrown long before the shutter's line is not this exposure's to the rig.
  change(RigLine::shutter, 1, std::min(first - open_ahead_, trigger + kLongestFlight));
  for (int i = 0; i < flashes_; ++i) {
    const MonoTime at = first + offset(i);
    rig_->collect(at, drives_, exposures_);
    for (const int level : {1, 0}) {
      for (const RigLine lamp : {RigLine::strobe_a, RigLine::strobe_b})
        change(lamp, level, level == 1 ? at : at + kLinePulse);
    }
  }
  const MonoTime end = last + milliseconds(10);
  change(RigLine::shutter, 0, std::max(end, trigger));
  rig_->finish(std::max(end, trigger), exposures_);
}

void Shooter::fill_frame(SimulatedShot& shot) const {
  Digitized digitized = settings_.perfect_digitizer ? digitize_perfectly(scene(), rig_->seed(), shot.exposure)
                                                    : digitize(scene(), rig_->seed(), shot.exposure);
  shot.frame = std::move(digitized.frame);
  shot.frame.shot_id = shot.exposure.shot;
  std::vector<reduction::BallImage>& images = shot.frame.images;
  std::size_t kept = 0;
  MonoTime start = kNoTime;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const MonoTime stamp = digitized.image_stamp[i];
    if (!known(stamp)) {
      set(shot, ShotFlag::unstamped_image);
      continue;
    }
    if (!known(start)) start = stamp;
    images[i].time_s = to_seconds(stamp - start);
    images[i].flash_index = digitized.image_pulse[i];
    if (kept != i) images[kept] = std::move(images[i]);
    digitized.image_pulse[kept++] = digitized.image_pulse[i];
  }
  images.resize(kept);
  digitized.image_pulse.resize(kept);
  shot.image_pulse = std::move(digitized.image_pulse);
}

SimulatedShot Shooter::shoot(int shot) {
  assert(shot >= 1);
  play(shot);
  assert(!exposures_.empty());  // the shutter was opened and closed
  SimulatedShot result;
  result.exposure = std::move(exposures_.back());
  fill_frame(result);
  if (result.exposure.ball) {
    if (!shows_impact(result.exposure)) set(result, ShotFlag::impact_unseen);
    result.truth = true_readout(scene(), result.exposure.ball->path);
  } else {
    set(result, result.exposure.has(FaultKind::ball_misses) ? ShotFlag::ball_missed : ShotFlag::no_ball);
  }
  return result;
}

Result<SimulatedShot> shoot(const Scene& scene, std::uint64_t seed, int shot, const Model& model,
                            const ShootSettings& settings) {
  if (shot < 1) return fail("shot: must be 1 or more");
  auto shooter = Shooter::make(scene, seed, model, settings);
  if (!shooter) return tl::unexpected(shooter.error());
  return shooter->shoot(shot);
}

}  // namespace strobe::sim
