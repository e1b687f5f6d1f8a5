#include "sim/plan/contact_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

unsigned left_out(const Model& model) {
  unsigned bits = 0;
  for (std::size_t i = 0; i < kContactEffects.size(); ++i) {
    if (!model.has(kContactEffects[i])) bits |= 1U << i;
  }
  return bits;
}

/// The model with all effects but those, and without those that the camera's bounds cover.
Model lacking(unsigned bits) {
  Model model = Model::full().without(Effect::pixels).without(Effect::flash_duration);
  for (std::size_t i = 0; i < kContactEffects.size(); ++i) {
    if ((bits >> i & 1U) != 0) model = model.without(kContactEffects[i]);
  }
  return model;
}

std::size_t rebounds(const NominalFrame& frame) {
  return static_cast<std::size_t>(
      std::ranges::count(frame.frame.images, reduction::Leg::rebound, &reduction::BallImage::leg));
}

PerQuantity everything_infinite() {
  PerQuantity all;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    all[i] = std::numeric_limits<double>::infinity();
  return all;
}

}  // namespace

ContactBounds::ContactBounds(const Scene& scene, const ShootSettings& settings) : scene_(scene) {
  const Train train = train_of(scene, settings);
  const ModelledScene full(scene, lacking(0));
  std::vector<Corner> points = corners(scene);
  for (const Corner& point : inside(scene, kInside)) points.push_back(point);
  for (std::size_t i = 0; i < points.size(); ++i) {
    Sample sample;
    sample.corner = points[i];
    const auto shot = NominalShot::make(full, points[i]);
    sample.ball = shot.has_value();
    for (int k = 0; k < kContactPhases && shot; ++k) {
      const auto p = static_cast<std::size_t>(k);
      // Phases differ from point to point: the golden ratio's multiples lie evenly.
      double turns = 0.61803398875 * static_cast<double>(i);
      // One flash in contact, while it passes for one in the air: its motion matters there.
      const NominalShot::Seen seen = shot->flattening_seen();
      const double share = 0.2 * static_cast<double>(i / 2 % 5) + 0.18;
      const double before_s = (shot->dwell_s() - seen.to_s) * share;
      if (k == 1) turns = (i % 2 == 0 ? share * seen.from_s : shot->dwell_s() - before_s) / train.period_s;
      sample.flashes[p] = shot->flashes(train, turns - std::floor(turns), 0.0);
      const NominalFrame frame = shot->photograph(sample.flashes[p]);
      sample.readouts[p] = readout_of(frame.frame);
      sample.rebounds[p] = rebounds(frame);
    }
    samples_.push_back(std::move(sample));
  }
}

const ContactBounds::Measured& ContactBounds::known(const Model& model) {
  const unsigned bits = left_out(model);
  const auto known = known_.find(bits);
  if (known != known_.end()) return known->second;
  return known_[bits] = bits == 0 ? Measured{} : measure(lacking(bits));
}

ContactBounds::Measured ContactBounds::measure(const Model& model) const {
  Measured result;
  const ModelledScene scene(scene_, model);
  for (const Sample& sample : samples_) {
    const auto shot = NominalShot::make(scene, sample.corner);
    if (shot.has_value() != sample.ball) return {everything_infinite(), 0.0};
    if (!shot) continue;
    for (std::size_t p = 0; p < kContactPhases; ++p) {
      const NominalFrame frame = shot->photograph(sample.flashes[p]);
      result.bound.max_with(difference(readout_of(frame.frame), sample.readouts[p]));
      const double more = static_cast<double>(rebounds(frame)) - static_cast<double>(sample.rebounds[p]);
      result.images_passing = std::max(result.images_passing, std::abs(more));
    }
  }
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) result.bound[i] *= kContactMargin;
  return result;
}

}  // namespace strobe::sim
