#include "sim/plan/sampled_shots.hpp"

#include <cmath>

namespace strobe::sim {

namespace {

constexpr std::uint64_t kSeed = 0x706c616e;

ShootSettings without_noise(ShootSettings settings) {
  settings.perfect_digitizer = true;
  return settings;
}

}  // namespace

double sampled_share() { return 1.0 - std::pow((1.0 - kConfidence) / kCandidates, 1.0 / kSampledShots); }

SampledShots::SampledShots(const Scene& scene, const ShootSettings& settings)
    : scene_(scene), settings_(without_noise(settings)) {
  if (auto shooter = Shooter::make(scene_, kSeed, Model::full(), settings_)) full_ = std::move(*shooter);
}

const reduction::Quantities& SampledShots::full_readout(int shot) {
  while (static_cast<int>(readouts_.size()) < shot)
    readouts_.push_back(readout_of(full_->shoot(static_cast<int>(readouts_.size()) + 1).frame));
  return readouts_[static_cast<std::size_t>(shot) - 1];
}

std::optional<PerQuantity> SampledShots::largest_change(const Model& model, const PerQuantity& allowed) {
  auto shooter = Shooter::make(scene_, kSeed, model, settings_);
  if (!shooter || !full_) return std::nullopt;
  PerQuantity largest;
  for (int shot = 1; shot <= kSampledShots; ++shot) {
    largest.max_with(difference(readout_of(shooter->shoot(shot).frame), full_readout(shot)));
    if (!within(largest, allowed)) return std::nullopt;
  }
  return largest;
}

}  // namespace strobe::sim
