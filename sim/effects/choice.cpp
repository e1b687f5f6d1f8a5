#include "sim/effects/choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/units/tolerance.hpp"

namespace strobe::sim {

namespace {

constexpr std::uint64_t kSeed = 0x706c616e;

/// Tolerances of the contact, coarsest first.
constexpr std::array kContactTolerances{1e-3, 1e-4, 1e-5, 1e-6, kFullContactTolerance};
static_assert(kContactTolerances.size() + 1 <= kCandidates);

ShootSettings without_noise(ShootSettings settings) {
  settings.perfect_digitizer = true;
  return settings;
}

/// Models that cost less than the one with all of these effects, the cheapest first.
std::vector<Model> candidates(const Scene& scene, const Model& present) {
  const bool mechanics = scene.bounce.contact == ContactLaw::ode;
  Model least = present;
  for (const Effect effect : kDecided) least = least.without(effect);
  std::vector<Model> models{mechanics ? least.with_contact_tolerance(kContactTolerances.front()) : least};
  for (const double tolerance : kContactTolerances) {
    if (mechanics || tolerance == kFullContactTolerance)
      models.push_back(present.without(Effect::pixels).with_contact_tolerance(tolerance));
  }
  return models;
}

}  // namespace

bool is_decided(Effect effect) { return std::ranges::find(kDecided, effect) != kDecided.end(); }

double sampled_share() { return 1.0 - std::pow((1.0 - kConfidence) / kCandidates, 1.0 / kSampledShots); }

Model effects_of(const Scene& scene) {
  const BounceSettings& b = scene.bounce;
  const bool ode = b.contact == ContactLaw::ode;
  const bool air = scene.air.density_kgpm3 != 0.0;
  const ShutterSettings& shutter = scene.shutter;
  return Model::full()
      .with(Effect::drag, air && scene.air.drag_coefficient > 0.0)
      .with(Effect::magnus, air && scene.air.lift)
      .with(Effect::spin_decay, scene.air.spin_decay_per_m > 0.0)
      .with(Effect::offset,
            ode ? b.offset_share > 0.0 || b.offset_share_sd > 0.0 : b.offset_m > 0.0 || b.offset_sd_m > 0.0)
      .with(Effect::tangential_compliance, ode || b.ex != 0.0 || b.ex_sd > 0.0)
      .with(Effect::contact_ode, ode)
      .with(Effect::flash_duration, scene.lamps.flash_s > 0.0)
      .with(Effect::lamp_delay, scene.lamps.delay_s > 0.0)
      .with(Effect::lamp_jitter, scene.lamps.jitter_s > 0.0)
      .with(Effect::sensor_delay, scene.sensors.delay_s > 0.0 || scene.sensors.jitter_s > 0.0)
      .with(Effect::shutter_lag,
            shutter.open_lag_s > 0.0 || shutter.close_lag_s > 0.0 || shutter.lag_sd_s > 0.0)
      .with(Effect::perspective, scene.camera.distance_m > 0.0)
      .with(Effect::lens_distortion, scene.camera.distortion != 0.0)
      .with(Effect::pixels, scene.camera.pixels);
}

ModelChooser::ModelChooser(const Scene& scene, const ShootSettings& settings)
    : scene_(scene), settings_(without_noise(settings)), present_(effects_of(scene)) {}

ModelChooser::Sample& ModelChooser::sample_of(const Model& model) {
  const auto known = std::ranges::find(samples_, model, &Sample::model);
  if (known != samples_.end()) return *known;
  auto shooter = Shooter::make(scene_, kSeed, model, settings_);
  return samples_.emplace_back(
      Sample{model, shooter ? std::optional<Shooter>(std::move(*shooter)) : std::nullopt});
}

std::optional<PerQuantity> ModelChooser::largest_change(const Model& model, const Model& other,
                                                        const PerQuantity& allowed) {
  const std::array<Sample*, 2> samples{&sample_of(model), &sample_of(other)};
  if (!samples[0]->shooter || !samples[1]->shooter) return std::nullopt;
  PerQuantity largest;
  for (std::size_t i = 0; i < kSampledShots; ++i) {
    for (Sample* s : samples)
      if (s->readouts.size() == i)
        s->readouts.push_back(readout_of(s->shooter->shoot(static_cast<int>(i) + 1).frame));
    largest.max_with(difference(samples[0]->readouts[i], samples[1]->readouts[i]));
    if (!within(largest, allowed)) return std::nullopt;
  }
  return largest;
}

ModelChoice ModelChooser::choose(double tolerance) {
  assert(tolerance > 0.0);
  ModelChoice choice{present_, tolerance, tolerances(scene_, tolerance), {}, {}};
  choice.allowed = choice.tolerances;
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) choice.allowed[q] *= kSampledPart;
  for (const Model& model : candidates(scene_, present_)) {
    choice.changed = largest_change(model, present_, choice.allowed);
    if (!choice.changed) continue;
    choice.model = model;
    break;
  }
  return choice;
}

PerQuantity ModelChooser::change_by(Effect effect) {
  PerQuantity any;
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q)
    any[q] = std::numeric_limits<double>::infinity();
  const Model with = effect == Effect::pixels ? present_ : present_.without(Effect::pixels);
  return largest_change(with.without(effect), with, any).value_or(any);
}

std::string explanation(const ModelChoice& choice, const Scene& scene) {
  const Model present = effects_of(scene);
  std::string left_out;
  for (const Effect effect : kDecided) {
    if (!present.has(effect) || choice.model.has(effect)) continue;
    left_out.append(left_out.empty() ? ", left out: " : ", ").append(name(effect));
  }
  std::string text = fmt::format("for {}", tolerance_text(choice.tolerance));
  text += left_out.empty() ? ", no effect is left out" : left_out;
  if (choice.model.contact_tolerance() != kFullContactTolerance)
    text += fmt::format("; the contact is solved to {:.0e}", choice.model.contact_tolerance());
  if (!choice.changed) return text;
  const reduction::Quantity most = worst(*choice.changed, choice.tolerances);
  return text + fmt::format(
                    "; in {} sampled shots {} changes most, by {:.2g}%: with {:.0f}% confidence fewer than "
                    "{:.2g}% of shots change a number by more than half of what is allowed",
                    kSampledShots, reduction::name(most),
                    100.0 * (*choice.changed)[most] / readout_scales(scene)[most], 100.0 * kConfidence,
                    100.0 * sampled_share());
}

}  // namespace strobe::sim
