// All fits of one photograph together, with the noise that the frame does not state estimated on the way
// and images that do not fit left out. Part of the reduction, not of its interface. Thread-safe; allocates.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/reduction/air_fit.hpp"
#include "common/reduction/joint_fit.hpp"
#include "common/reduction/observations.hpp"
#include "common/reduction/spin_fit.hpp"

namespace strobe::reduction {

/// What is known of a noise variance that the frame did not state; its value is Observations::group_sd.
struct VarianceComponent {
  bool used = false;                ///< some measurement has it
  double degrees_of_freedom = 0.0;  ///< measurements less what the fit took of them
};

struct ShotFit {
  Observations observations;
  flight::Effects effects;  ///< what the paths were fitted with
  flight::Aerodynamics air;
  /// domega/dt over -|v|·omega: friction goes with drag, but matters to the spin alone, so that it stays
  /// where drag is left out because it does not matter to the path.
  double spin_decay_per_m = 0.0;
  double spin_decay_sd_per_m = 0.0;
  /// A spin may be any of its alternatives as well: the lift's whole range is left to the path.
  bool spins_open = false;
  JointFit joint;
  /// Of the rounds of fits and of noise estimated from their residuals.
  FitStatus noise_status = FitStatus::converged;
  AirFit air_fit;
  /// Added to what is known of the air before (AirError::mean): asks what another air would have made of the
  /// numbers.
  std::array<double, kAirErrorCount> air_shift{};
  std::array<std::optional<SpinFit>, 2> spin;           ///< incoming, rebound
  std::array<std::vector<EquatorReading>, 2> equators;  ///< what the spins were fitted to
  std::vector<bool> equator_seen;  ///< per image: it came with an equator, whether it is used or was left out
  std::array<VarianceComponent, kNoiseGroupCount> variance_components;  ///< index: NoiseGroup
};

struct FitOptions {
  flight::Effects effects;
  bool reject_outliers = true;
  bool spins_open = false;  ///< see ShotFit
};

/// Which spins of either leg are looked for.
std::array<SpinSearch, 2> spin_search(const ShotFit& fit);

/// Sets the flags outlier_image, sd_from_residuals and spin_aliased.
ShotFit fit_shot(Observations observations, FitOptions options, FlagSet& flags);

/// Of a leg, see spin_fit.hpp: beyond the assumed limit, up to kTearingRim_mps; none where one was stated.
std::vector<OtherSpin> faster_spins(const ShotFit& fit, std::size_t leg);

/// The same images once more with other effects.
void refit(ShotFit& fit, flight::Effects effects);

}  // namespace strobe::reduction
