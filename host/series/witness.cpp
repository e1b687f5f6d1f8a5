#include "host/series/witness.hpp"

#include <cmath>

#include "common/units/angles.hpp"

namespace strobe::host {
namespace {

using reduction::Estimate;
using Value = std::optional<WitnessValue>;

Value lamp_delay(const std::optional<CalibratedDelay>& seen, double stated_us, double tolerance_us) {
  if (!seen) return std::nullopt;
  return WitnessValue{{seen->mean, std::hypot(seen->mean_sd, kLampWander_us)},
                      Estimate{stated_us, tolerance_us}};
}

Value gravity(const std::optional<Estimate>& told, double local_mps2) {
  if (!told) return std::nullopt;
  return WitnessValue{*told, Estimate{local_mps2, kAirShareOfGravity * local_mps2}};
}

Value clock(const std::optional<double>& drift_ppm) {
  if (!drift_ppm) return std::nullopt;
  return WitnessValue{{*drift_ppm, kClockWander_ppm}, Estimate{0.0, kClockWander_ppm}};
}

Value alone(const std::optional<Estimate>& told, const std::optional<Estimate>& reference = {}) {
  return told ? Value{WitnessValue{*told, reference}} : std::nullopt;
}

std::optional<Estimate> in_degrees(const std::optional<Estimate>& rad) {
  return rad ? std::optional(Estimate{degrees(rad->value), degrees(rad->sd)}) : std::nullopt;
}

}  // namespace

std::string_view words(Witness w) {
  constexpr std::array<std::string_view, kWitnessCount> kWords{"gravity by the balls' fall",
                                                               "scale by the balls' diameters",
                                                               "the surface line's inclination",
                                                               "delay of lamp A",
                                                               "delay of lamp B",
                                                               "this computer's clock against the rig's",
                                                               "deviations from the paths"};
  return kWords[static_cast<std::size_t>(w)];
}

ShotWitnesses witnesses(const Shot& shot) {
  if (shot.rejected) return {};
  const CommissionTable bench = shot.rig ? shot.rig->commission : CommissionTable{};
  const reduction::PhotographWitnesses photograph = shot.witnesses.value_or(reduction::PhotographWitnesses{});
  const DelayCalibration& lamps = shot.train.calibration;
  return {{gravity(photograph.gravity_mps2, bench.gravity_mps2),
           alone(photograph.diameters_px_per_m, photograph.stated_px_per_m),
           alone(in_degrees(photograph.surface_rad)),
           lamp_delay(lamps.lamp_a_us, lamps.stated_a_us, bench.delay_tolerance_us),
           lamp_delay(lamps.lamp_b_us, lamps.stated_b_us, bench.delay_tolerance_us),
           clock(shot.clock_drift_ppm), alone(photograph.path_residuals)},
          photograph.calibrated};
}

}  // namespace strobe::host
