#include "common/reduction/reduce.hpp"

#include <charconv>
#include <cmath>
#include <utility>

#include "common/reduction/legacy.hpp"
#include "common/reduction/propagate.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {
namespace {

/// From the frame, or from the session's record if that has a number there.
std::optional<double> temperature_c(const Frame& frame) {
  if (frame.temperature_c) return frame.temperature_c;
  const auto entry = frame.record.find("temperature_c");
  if (entry == frame.record.end()) return std::nullopt;
  const std::string& text = entry->second;
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Keeps the two images next to the impact, and the two next to it that show the equator. Diameters stay: the
/// mean of all of them is the scale.
void keep_nearest(Observations& all) {
  for (const Leg leg : {Leg::incoming, Leg::rebound}) {
    int centres = 0;
    int equators = 0;
    const std::size_t count = all.images.size();
    for (std::size_t i = 0; i < count; ++i) {
      Observation& o = all.images[leg == Leg::incoming ? count - 1 - i : i];
      if (o.leg != leg) continue;
      if (o.use_centre && ++centres > 2) o.use_centre = false;
      if (o.use_equator && ++equators > 2) o.use_equator = false;
    }
  }
}

void flag_redundancy(const Observations& all, FlagSet& flags) {
  int count[2] = {0, 0};
  for (const Observation& o : all.images) {
    if (o.use_centre) ++count[leg_index(*o.leg)];
  }
  if (count[0] == 2 || count[1] == 2) flags.set(Flag::no_redundancy);
}

Readout fitted_readout(const Frame& frame, Estimator estimator, const ReduceOptions& options) {
  Readout readout;
  readout.shot_id = frame.shot_id;
  readout.record = frame.record;
  readout.method = estimator == Estimator::best ? "best" : "two-point";
  std::optional<Observations> observations = observe(frame, readout.flags);
  if (!observations) return readout;
  readout.mirrored = observations->levelling.mirrored;
  const bool best = estimator == Estimator::best;
  if (!best) {
    flag_redundancy(*observations, readout.flags);
    keep_nearest(*observations);
  }
  const ShotFit fit = fit_shot(
      std::move(*observations),
      {.gravity = best && options.effects.value_or(flight::kGravityOnly).gravity, .leave_out_outliers = best},
      readout.flags);
  if (best) flag_redundancy(fit.observations, readout.flags);
  propagate(fit, temperature_c(frame), readout);
  return readout;
}

}  // namespace

Result<Readout> reduce(const Frame& frame, Estimator estimator, const ReduceOptions& options) {
  if (const auto complaint = invalid(frame)) return fail(*complaint);
  if (estimator == Estimator::legacy) return reduce_legacy(frame);
  return fitted_readout(frame, estimator, options);
}

}  // namespace strobe::reduction
