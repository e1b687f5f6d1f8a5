#include "tests/studies/drift/study.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "host/assembly/flash_times.hpp"
#include "host/clock/device_clock.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/host/heartbeats.hpp"
#include "tests/studies/in_parallel.hpp"

namespace strobe::studies {
namespace {

using reduction::Frame;
using strobe_msgs::flash_t;
using strobe_msgs::shot_t;

constexpr std::size_t kKinds = kDriftKindNames.size();
/// Of the calibration and of the ball.
constexpr double kScaleSd = 0.001, kBallSd_m = 0.0008;

sim::Shooter shooter_of(const sim::Scene& scene, std::uint64_t seed) {
  auto shooter = sim::Shooter::make(scene, seed, sim::Model::full(), {.perfect_digitizer = true});
  assert(shooter);
  return std::move(*shooter);
}

sim::Scene drifted(sim::Scene scene, const DriftPlan& plan, DriftKind kind) {
  if (kind == DriftKind::scale) scene.camera.px_per_m *= 1.0 + plan.scale;
  if (kind == DriftKind::tilt) scene.camera.roll_rad += plan.tilt_deg * std::numbers::pi / 180.0;
  return scene;
}

/// A rig whose shots are measured and told of as a host hears them.
class Bench {
 public:
  Bench(const DriftPlan& plan, const sim::Scene& scene, std::optional<DriftKind> kind, std::uint64_t seed)
      : plan_(plan),
        scene_(scene),
        kind_(kind),
        sound_(shooter_of(scene, seed)),
        drifted_(shooter_of(kind ? drifted(scene, plan, *kind) : scene, seed)),
        random_(seed),
        beats_(static_cast<unsigned>(seed)) {
    listen(40.0);
  }

  host::Shot shot(int number, bool off) {
    constexpr double kBetween_s = 15.0;
    const sim::SimulatedShot seen = (off ? drifted_ : sound_).shoot(number);
    const bool fast = off && kind_ == DriftKind::clock;
    if (fast) beats_.change_drift(-plan_.clock);
    listen(kBetween_s);
    host::Shot shot;
    shot.name = std::to_string(number);
    const auto witnesses = reduction::photograph_witnesses(measured(seen.frame, fast ? 1.0 + plan_.clock : 1.0));
    if (witnesses) shot.witnesses = *witnesses;
    shot.summary = told(seen.exposure, off && kind_ == DriftKind::lamp ? plan_.lamp_us : 0.0);
    shot.train = host::train_report(*shot.summary, host::flash_times(*shot.summary));
    shot.clock_drift_ppm = clock_.state().drift_ppm;
    return shot;
  }

 private:
  double noise(double sd) { return sd * normal_(random_); }

  void listen(double seconds) {
    for (int i = 0; i < std::lround(2.0 * seconds); ++i) beats_.send(clock_);
  }

  Frame measured(Frame frame, double clock_rate) {
    frame.px_per_m = scene_.camera.px_per_m;
    frame.px_per_m_sd = kScaleSd * scene_.camera.px_per_m;
    frame.ball_diameter_sd_m = kBallSd_m;
    frame.centre_sd_px = frame.surface_sd_px = plan_.noise.centre_px;
    frame.diameter_sd_px = plan_.noise.diameter_px;
    frame.equator_sd_rad = plan_.noise.equator_rad;
    for (reduction::PointPx& p : frame.surface_px) move(p);
    for (reduction::BallImage& image : frame.images) {
      move(image.centre_px);
      image.diameter_px += noise(plan_.noise.diameter_px);
      if (image.equator_rad) *image.equator_rad += noise(plan_.noise.equator_rad);
      image.time_s *= clock_rate;
    }
    return frame;
  }

  void move(reduction::PointPx& p) {
    p.x += noise(plan_.noise.centre_px);
    p.y += noise(plan_.noise.centre_px);
  }

  /// Pulses are issued when commanded; lamp A's flash comes so much later.
  shot_t told(const sim::Exposure& exposure, double more_us) const {
    shot_t shot{};
    shot.lamp_delay_a_us = shot.lamp_delay_b_us = scene_.lamps.delay_s * 1e6;
    shot.sensor_a_fitted = shot.sensor_b_fitted = true;
    shot.late_tolerance_us = 100.0;
    for (const sim::Pulse& pulse : exposure.pulses) {
      flash_t flash{};
      flash.lamps = 3;
      flash.flash_index = static_cast<std::int32_t>(shot.flashes.size());
      flash.commanded_ns = flash.issue_start_ns = flash.issue_end_ns = to_ns(pulse.edge);
      const bool both = pulse.lamps == std::array{1, 1} && pulse.stamps.size() == 2;
      flash.observed_a_ns = both ? to_ns(pulse.stamps[0]) + std::llround(1e3 * more_us) : flash_t::NO_TIME;
      flash.observed_b_ns = both ? to_ns(pulse.stamps[1]) : flash_t::NO_TIME;
      shot.flashes.push_back(flash);
    }
    shot.flash_count = static_cast<std::int32_t>(shot.flashes.size());
    return shot;
  }

  const DriftPlan& plan_;
  const sim::Scene& scene_;
  std::optional<DriftKind> kind_;
  sim::Shooter sound_, drifted_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  host_test::Heartbeats beats_;
  host::DeviceClock clock_;
};

constexpr std::array kCulprits{host::Culprit::scale, host::Culprit::clock, host::Culprit::tilt,
                               host::Culprit::lamp_a};

void judge(const host::WitnessCharts& charts, host::Culprit true_one, int& alone, int* among) {
  const auto found = charts.verdict()->culprits;
  const bool named = std::ranges::find(found, true_one) != found.end();
  alone += named && found.size() == 1 ? 1 : 0;
  if (among) *among += named ? 1 : 0;
}

DriftTold drift_once(const DriftPlan& plan, const sim::Scene& scene, DriftKind kind, std::uint64_t seed) {
  DriftTold told;
  told.runs = 1;
  Bench bench(plan, scene, kind, seed);
  host::WitnessCharts charts;
  const host::Culprit true_one = kCulprits[static_cast<std::size_t>(kind)];
  int number = 0;
  for (; number < plan.before; ++number) {
    if (charts.add("", witnesses(bench.shot(number + 1, false))).empty()) continue;
    told.early = 1;
    return told;
  }
  for (int shot = 1; shot <= plan.after; ++shot) {
    const auto alarms = charts.add("", witnesses(bench.shot(++number, true)));
    if (alarms.empty()) continue;
    told.shots.push_back(shot);
    for (const host::Witness w : alarms) ++told.told_by[static_cast<std::size_t>(w)];
    judge(charts, true_one, told.right, &told.among);
    for (int more = 0; more < plan.later; ++more) charts.add("", witnesses(bench.shot(++number, true)));
    judge(charts, true_one, told.right_later, nullptr);
    break;
  }
  return told;
}

/// Sound shots in series that begin anew after an alarm, and after 200.
void sound_shots(const DriftPlan& plan, const sim::Scene& scene, int shots, std::uint64_t seed,
                 DriftStudy& study) {
  constexpr int kSeries = 200;
  Bench bench(plan, scene, std::nullopt, seed);
  std::optional<host::WitnessCharts> charts;
  for (int i = 0; i < shots; ++i) {
    if (!charts || std::ssize(charts->shots()) == kSeries) charts.emplace();
    const auto alarms = charts->add("", witnesses(bench.shot(i + 1, false)));
    ++study.sound;
    if (alarms.empty()) continue;
    ++study.false_alarms;
    for (const host::Witness w : alarms) ++study.false_by[static_cast<std::size_t>(w)];
    charts.reset();
  }
}

void add(const std::array<int, host::kWitnessCount>& some, std::array<int, host::kWitnessCount>& all) {
  for (std::size_t i = 0; i < all.size(); ++i) all[i] += some[i];
}

void add(const DriftTold& one, DriftTold& all) {
  all.shots.insert(all.shots.end(), one.shots.begin(), one.shots.end());
  all.runs += one.runs, all.early += one.early;
  all.right += one.right, all.right_later += one.right_later, all.among += one.among;
  add(one.told_by, all.told_by);
}

}  // namespace

int total_runs(const DriftPlan& plan) {
  return static_cast<int>(plan.scenes.size()) * (1 + static_cast<int>(kKinds) * plan.runs);
}

DriftStudy run(const DriftPlan& plan, std::atomic<int>& done) {
  const std::size_t each = 1 + kKinds * static_cast<std::size_t>(plan.runs);
  std::vector<DriftStudy> of_run(plan.scenes.size() * each);
  const int sound = plan.sound / static_cast<int>(plan.scenes.size());
  in_parallel(of_run.size(), static_cast<unsigned>(plan.threads), [&](std::size_t i) {
    const sim::Scene& scene = plan.scenes[i / each];
    const std::uint64_t seed = plan.seed * 1'000'003 + i;
    const std::size_t which = i % each;
    if (which == 0)
      sound_shots(plan, scene, sound, seed, of_run[i]);
    else
      of_run[i].told[which % kKinds] = drift_once(plan, scene, static_cast<DriftKind>(which % kKinds), seed);
    ++done;
  });
  DriftStudy all;
  for (const DriftStudy& one : of_run) {
    for (std::size_t k = 0; k < kKinds; ++k) add(one.told[k], all.told[k]);
    all.sound += one.sound, all.false_alarms += one.false_alarms;
    add(one.false_by, all.false_by);
  }
  for (DriftTold& told : all.told) std::ranges::sort(told.shots);
  return all;
}

}  // namespace strobe::studies
