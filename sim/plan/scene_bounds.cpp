#include "sim/plan/scene_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "sim/plan/camera_bounds.hpp"
#include "sim/plan/displacement.hpp"
#include "sim/plan/sensitivity.hpp"
#include "sim/plan/timing_bounds.hpp"
#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

using reduction::Quantity;

constexpr std::array kImageEffects{
    Effect::gravity,        Effect::drag,        Effect::magnus,          Effect::spin_decay,
    Effect::lamp_delay,     Effect::lamp_jitter, Effect::sensor_delay,    Effect::shutter_lag,
    Effect::flash_duration, Effect::perspective, Effect::lens_distortion, Effect::pixels};

PerQuantity times(PerQuantity bound, double factor) {
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) {
    if (bound[q] != 0.0) bound[q] *= factor;
  }
  return bound;
}

/// Pixels are left to the camera's bounds; the flash's length triples the cost and changes nothing else.
const Model kStudied = Model::full().without(Effect::pixels).without(Effect::flash_duration);

PerQuantity all_infinite() {
  PerQuantity bound;
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) bound[q] = kNoBound;
  return bound;
}

/// For each effect of the lens, where the hand sees the surface without it.
using SurfacePoints = std::array<std::vector<reduction::PointPx>, kEffectCount>;

SurfacePoints surface_without_lens(const Scene& scene) {
  SurfacePoints points;
  for (const Effect effect : {Effect::perspective, Effect::lens_distortion}) {
    const ModelledScene modelled(scene, kStudied.without(effect));
    const auto shot = NominalShot::make(modelled, Corner{});
    if (shot) points[static_cast<std::size_t>(effect)] = shot->photograph({}).frame.surface_px;
  }
  return points;
}

/// One frame of one corner's train.
struct Exposed {
  std::vector<NominalFlash> flashes;
  NominalFrame photograph;
  reduction::Quantities readout;
};

/// What one corner's balls show, with all effects but the pixels.
class CornerStudy {
 public:
  CornerStudy(const Scene& scene, const NominalShot& shot, const Train& train, double late_s,
              const std::array<bool, kEffectCount>& present, const SurfacePoints& surface_without)
      : scene_(scene),
        shot_(shot),
        train_(train),
        present_(present),
        surface_without_(surface_without),
        flight_(scene),
        timing_(scene),
        camera_(scene) {
    for (const double phase : phases_of(shot, train.period_s)) {
      Exposed e;
      e.flashes = shot.flashes(train, phase, late_s);
      e.photograph = shot.photograph(e.flashes);
      e.readout = readout_of(e.photograph.frame);
      phases_.push_back(std::move(e));
    }
  }

  const std::vector<Exposed>& phases() const { return phases_; }

  /// Steps between neighbouring phases: the sum of each quantity's kThresholds largest, which images that
  /// come and go may have caused, and the largest of the others.
  void steps(PerQuantity& threshold_steps, PerQuantity& drift) const {
    const std::size_t count = phases_.size();
    std::array<std::vector<double>, reduction::kQuantityCount> all;
    for (auto& steps : all) steps.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
      const PerQuantity step = difference(phases_[k].readout, phases_[(k + 1) % count].readout);
      for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) all[q][k] = step[q];
    }
    for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) {
      std::ranges::sort(all[q], std::greater<>());
      threshold_steps[q] = 0.0;
      for (std::size_t k = 0; k < kThresholds; ++k) threshold_steps[q] += all[q][k];
      drift[q] = all[q][kThresholds];
    }
  }

  /// Adds what each image effect does at one phase, where it is larger than before; and how many images it
  /// may carry past a threshold.
  void measure(std::size_t phase, std::array<PerQuantity, kEffectCount>& bounds,
               std::array<double, kEffectCount>& passing) const {
    const Exposed& e = phases_[phase];
    const Sensitivity sensitivity(e.photograph.frame, scene_.camera.mirrored, wanted());
    for (const Effect effect : kImageEffects) {
      if (!present_[static_cast<std::size_t>(effect)]) continue;
      const std::vector<BoundedDisplacement> displaced = images(e, effect);
      PerQuantity bound = sensitivity.propagated(displaced, surface(e, effect));
      double& most = passing[static_cast<std::size_t>(effect)];
      most = std::max(most, images_passing(e, displaced));
      if (timing_.shift_s(effect) > 0.0) bound += of_shifted_flashes(e, timing_.shift_s(effect));
      bounds[static_cast<std::size_t>(effect)].max_with(bound);
    }
  }

  /// What the jitter of one image's time can do, the largest over the images.
  PerQuantity of_one_stamp(std::size_t phase) const {
    const Exposed& e = phases_[phase];
    const Sensitivity sensitivity(e.photograph.frame, scene_.camera.mirrored,
                                  {false, false, false, false, true});
    const std::vector<BoundedDisplacement> all = images(e, Effect::sensor_delay);
    PerQuantity largest;
    for (std::size_t i = 0; i < all.size(); ++i) {
      std::vector<BoundedDisplacement> one(all.size());
      one[i] = all[i];
      largest.max_with(sensitivity.propagated(one));
    }
    return largest;
  }

  std::size_t fewest_images() const {
    const auto count = [](const Exposed& e) { return e.photograph.frame.images.size(); };
    return static_cast<std::size_t>(std::ranges::min_element(phases_, {}, count) - phases_.begin());
  }

  std::size_t another(std::size_t number) const { return (7 * number + 3) % phases_.size(); }

 private:
  /// Evenly over a period, and besides within and to both sides of where an image in contact passes for one
  /// in the air: what it is off its leg's path grows steeply there, until it is seen to be in contact.
  static std::vector<double> phases_of(const NominalShot& shot, double period_s) {
    constexpr double kBeside_s = 1e-7;
    constexpr int kWithin = 4;
    std::vector<double> times_s;
    for (int k = 0; k < kPhases; ++k) times_s.push_back(k * period_s / kPhases);
    const NominalShot::Seen seen = shot.flattening_seen();
    for (int k = 1; k <= kWithin; ++k) {
      const double share = static_cast<double>(k) / kWithin;
      times_s.push_back(share * seen.from_s - kBeside_s);
      times_s.push_back(shot.dwell_s() - share * (shot.dwell_s() - seen.to_s) + kBeside_s);
    }
    times_s.push_back(seen.from_s + kBeside_s);
    times_s.push_back(seen.to_s - kBeside_s);
    for (double& t : times_s) t = t / period_s - std::floor(t / period_s);
    std::ranges::sort(times_s);
    return times_s;
  }

  CoordinateMask wanted() const {
    const auto has = [&](Effect effect) { return present_[static_cast<std::size_t>(effect)]; };
    const bool lens = has(Effect::perspective) || has(Effect::lens_distortion) || has(Effect::pixels);
    return {true, true, lens, lens || has(Effect::spin_decay), has(Effect::sensor_delay)};
  }

  std::vector<BoundedDisplacement> images(const Exposed& e, Effect effect) const {
    std::vector<BoundedDisplacement> all;
    for (std::size_t i = 0; i < e.photograph.frame.images.size(); ++i) {
      const double time_s = e.flashes[e.photograph.flash[i]].time_s;
      const bool rebounding = e.photograph.frame.images[i].leg == reduction::Leg::rebound;
      const LegMotion leg = rebounding ? shot_.rebound() : shot_.incoming();
      const double from_surface_s = std::max(0.0, rebounding ? time_s - shot_.dwell_s() : -time_s);
      const BallState state = shot_.path().at(time_s);
      all.push_back(flight_.of(effect, leg, from_surface_s) + timing_.of(effect, leg, from_surface_s) +
                    camera_.of_ball(effect, state.x_m + shot_.path().spot_m(), state.y_m,
                                    shot_.path().off_plane_m(), state.equator_rad));
      // What the flash's length does to a picture of pixels goes with either of the two.
      if (effect == Effect::flash_duration || effect == Effect::pixels)
        all.back().within.equator_rad += camera_.motion_blur_rad(std::hypot(state.vx_mps, state.vy_mps));
    }
    return all;
  }

  /// Displacement over the spacing of the images, along and across the surface.
  double images_passing(const Exposed& e, const std::vector<BoundedDisplacement>& displaced) const {
    double most = 0.0;
    for (std::size_t i = 0; i < displaced.size(); ++i) {
      const BallState state = shot_.path().at(e.flashes[e.photograph.flash[i]].time_s);
      const BoundedDisplacement& d = displaced[i];
      const double x = (std::abs(d.by.x_m) + d.within.x_m) / (std::abs(state.vx_mps) * train_.period_s);
      const double y = (std::abs(d.by.y_m) + d.within.y_m) / (std::abs(state.vy_mps) * train_.period_s);
      most = std::max(most, std::isnan(x + y) ? 0.0 : x + y);
    }
    return std::min(most, static_cast<double>(displaced.size()));
  }

  std::vector<BoundedDisplacement> surface(const Exposed& e, Effect effect) const {
    const auto& points = e.photograph.frame.surface_px;
    std::vector<BoundedDisplacement> all(points.size());
    const auto& without = surface_without_[static_cast<std::size_t>(effect)];
    for (std::size_t i = 0; i < without.size(); ++i)
      all[i] = camera_.of_surface(effect, scene_.camera.half_width_m, points[i].x - without[i].x,
                                  points[i].y - without[i].y);
    return all;
  }

  /// Each image in turn with its flash, moved on its path and stamped there.
  PerQuantity of_shifted_flashes(const Exposed& e, double shift_s) const {
    PerQuantity sum;
    reduction::Frame moved = e.photograph.frame;
    for (std::size_t i = 0; i < moved.images.size(); ++i) {
      if (moved.images[i].leg == reduction::Leg::contact) continue;
      NominalFlash flash = e.flashes[e.photograph.flash[i]];
      flash.time_s += shift_s;
      const NominalFrame alone = shot_.photograph(std::span(&flash, 1));
      // A threshold passed meanwhile is not this image's change but a threshold step.
      if (alone.frame.images.size() != 1 || alone.frame.images[0].leg != moved.images[i].leg) continue;
      reduction::BallImage& image = moved.images[i];
      image = alone.frame.images[0];
      image.time_s = e.photograph.frame.images[i].time_s + shift_s;
      sum += difference(readout_of(moved), e.readout);
      image = e.photograph.frame.images[i];
    }
    return sum;
  }

  const Scene& scene_;
  const NominalShot& shot_;
  Train train_;
  const std::array<bool, kEffectCount>& present_;
  const SurfacePoints& surface_without_;
  FlightBounds flight_;
  TimingBounds timing_;
  CameraBounds camera_;
  std::vector<Exposed> phases_;
};

}  // namespace

SceneBounds::SceneBounds(const Scene& scene, const ShootSettings& settings)
    : scene_(scene), contact_(scene, settings), samples_(scene, settings) {
  present_ = effects_of(scene);
  measure(settings);
  look_for_warnings(settings);
}

void SceneBounds::measure(const ShootSettings& settings) {
  const Train train = train_of(scene_, settings);
  const TimingBounds timing(scene_);
  const std::vector<Corner> points = corners(scene_);
  PerQuantity largest_drift;
  std::array<bool, reduction::kQuantityCount> lost{};
  const ModelledScene modelled(scene_, kStudied);
  const SurfacePoints surface_without = surface_without_lens(scene_);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto shot = NominalShot::make(modelled, points[i]);
    if (!shot) continue;  // no ball, in no model; contact_ sees to models that disagree
    const double late_s = (i % 2 == 0 ? 1.0 : -1.0) * kLargestNormal * scene_.machine.lag_sd_s;
    const CornerStudy study(scene_, *shot, train, late_s, present_, surface_without);
    for (const Exposed& e : study.phases()) {
      for (std::size_t q = 0; q < reduction::kQuantityCount; ++q)
        lost[q] = lost[q] || !e.readout[static_cast<Quantity>(q)];
      if (const auto dwell = e.readout[Quantity::dwell_time_ms])
        least_dwell_ms_ = std::min(least_dwell_ms_, *dwell);
    }
    PerQuantity threshold_steps;
    PerQuantity drift;
    study.steps(threshold_steps, drift);
    threshold_steps_.max_with(threshold_steps);
    largest_drift.max_with(drift);
    study.measure(study.fewest_images(), images_, passing_);
    if (present(Effect::sensor_delay)) one_stamp_.max_with(study.of_one_stamp(study.fewest_images()));
    study.measure(study.another(i), images_, passing_);
  }
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) {
    if (lost[q]) threshold_steps_[q] = kNoBound;
  }
  for (PerQuantity& bound : images_) bound = times(bound, kImageMargin);
  // All flashes together: the train's phase moves, and readouts drift with it.
  for (const Effect effect : {Effect::lamp_delay, Effect::flash_duration}) {
    const double steps = timing.common_shift_s(effect) * kPhases / train.period_s;
    if (steps > 0.0) images_[static_cast<std::size_t>(effect)] += times(largest_drift, kImageMargin * steps);
  }
}

void SceneBounds::look_for_warnings(const ShootSettings& settings) {
  const double period_s = to_seconds(settings.period);
  const double jitter_s = 2.0 * kLargestNormal * scene_.lamps.jitter_s;
  if (!scene_.faults.empty()) warning_ = "the scene has faults: which images there are is theirs to decide";
  if (period_s - jitter_s < scene_.lamps.recharge_s)
    warning_ = "a lamp may not have recharged by the next flash";
  double fastest_spin = 0.0;
  double longest_m = 0.0;
  bool steep = false;
  const ModelledScene modelled(scene_, kStudied);
  for (const Corner& point : corners(scene_)) {
    const auto shot = NominalShot::make(modelled, point);
    if (!shot) continue;
    for (const LegMotion& leg : {shot->incoming(), shot->rebound()})
      fastest_spin = std::max(fastest_spin, std::abs(leg.omega_radps));
    const LegMotion in = shot->incoming();
    const double steepness = std::abs(in.vy_mps) / std::max(in.vx_mps, 1e-9);
    longest_m = std::max(longest_m, scene_.camera.half_width_m * std::hypot(1.0, std::min(steepness, 30.0)));
    steep = steep || steepness > 15.0;
  }
  // The reduction reads spins within a quarter turn a period, and a ball that falls straight as going right.
  if (1.05 * fastest_spin * 2.0 * (period_s + jitter_s) > std::numbers::pi)
    warning_ = "a spin may turn the equator by more than a quarter turn between flashes";
  if (scene_.camera.mirrored && steep)
    warning_ = "a ball may fall too straight to tell the side it is seen from";
  const FlightBounds flight(scene_);
  if (longest_m * flight.largest_coefficient_pm() > 0.09)
    warning_ = "the air bends a leg by more than the reduction's series holds for";
  if (!warning_.empty()) threshold_steps_ = all_infinite();
}

PerQuantity SceneBounds::of(Effect effect) {
  if (!present(effect)) return {};
  return of_contact(effect) ? contact_.of(Model::full().without(effect))
                            : images_[static_cast<std::size_t>(effect)];
}

PerQuantity SceneBounds::of(const Model& model) {
  PerQuantity sum;
  double passing = contact_.images_passing(model);
  for (const Effect effect : kImageEffects) {
    if (model.has(effect) || !present(effect)) continue;
    sum += images_[static_cast<std::size_t>(effect)];
    passing += passing_[static_cast<std::size_t>(effect)];
  }
  sum += contact_.of(model);
  if (sum.all_zero()) return sum;
  sum += times(threshold_steps_, 1.0 + passing);
  // An image that appears or disappears adds or removes its time's jitter.
  if (present(Effect::sensor_delay) && model.has(Effect::sensor_delay))
    sum += times(one_stamp_, 2.0 * kImageMargin * (1.0 + passing));
  // The effect of pixels differs from place to place.
  if (present(Effect::pixels) && model.has(Effect::pixels))
    sum += times(images_[static_cast<std::size_t>(Effect::pixels)], 2.0);
  no_bound_where_large(sum);
  return sum;
}

void SceneBounds::no_bound_where_large(PerQuantity& sum) const {
  const PerQuantity scale = readout_scales(scene_);
  bool bent = false;
  for (const Quantity q :
       {Quantity::theta_in_deg, Quantity::theta_out_deg, Quantity::v_td_mps, Quantity::v_lo_mps,
        Quantity::vx_td_mps, Quantity::vy_td_mps, Quantity::vx_lo_mps, Quantity::vy_lo_mps})
    bent = bent || sum[q] > kSmall * scale[q];
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) {
    if (bent || sum[q] > kSmall * scale[q]) sum[q] = kNoBound;
  }
  // A negative dwell time is no number.
  if (sum[Quantity::dwell_time_ms] >= least_dwell_ms_)
    sum[Quantity::dwell_time_ms] = sum[Quantity::dwell_distance_cm] = kNoBound;
}

}  // namespace strobe::sim
