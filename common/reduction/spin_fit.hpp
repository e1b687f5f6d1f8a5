// Spin of one leg from the angles of the ball's equator, which are known modulo half a turn.
// Part of the reduction, not of its interface. Thread-safe; allocates.
#pragma once

#include <optional>
#include <vector>

namespace strobe::reduction {

/// One reading of the equator. The index is the caller's.
struct EquatorReading {
  double time_s = 0.0;
  double angle_rad = 0.0;  ///< modulo pi
  double sd_rad = 0.0;
  double time_sd_s = 0.0;
  bool estimated_noise = false;  ///< sd_rad was estimated from residuals
  std::size_t index = 0;
};

struct SpinFit {
  double omega_radps = 0.0;
  double variance = 0.0;            ///< of omega [rad^2/s^2]
  double estimated_variance = 0.0;  ///< the part of it that comes from estimated noise
  double angle_rad = 0.0;           ///< at time mean_time_s, unwrapped
  double mean_time_s = 0.0;
  double chi_squared = 0.0;
  bool aliased = false;              ///< another half turn between the images explains them as well
  std::vector<double> residual_rad;  ///< per reading
  std::vector<double> leverage;      ///< per reading: share of its own in its fitted angle
};

/// The most likely steady spin with |omega| < pi / (2 T), T being the shortest interval between two readings.
/// Each pair of neighbours proposes spins; each proposal is followed outward image by image, so that noise
/// over a long leg cannot lose a half turn; the likeliest one is kept, by a cost that one bad reading cannot
/// dominate. Returns nullopt for fewer than two readings. Readings are in order of time, times differ.
///
/// `left_out`: readings whose image did not fit its leg. The line does not go through them, but they count
/// for T and for the cost: with every second image left out the others alone could not tell half a turn more.
std::optional<SpinFit> fit_spin(const std::vector<EquatorReading>& readings,
                                const std::vector<EquatorReading>& left_out = {});

}  // namespace strobe::reduction
