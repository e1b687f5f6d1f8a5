// Spin of one leg from the angles of the ball's equator, which are known modulo half a turn.
// Part of the reduction, not of its interface. Thread-safe; allocates.
#pragma once

#include <limits>
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
  double omega_radps = 0.0;         ///< at time_s
  double variance = 0.0;            ///< of omega [rad^2/s^2]
  double estimated_variance = 0.0;  ///< the part of it that comes from estimated noise
  double time_s = 0.0;              ///< mean of the readings'
  double chi_squared = 0.0;         ///< of all readings, with `decay_square`
  double decay_square = 0.0;        ///< squared deviation of the decay from the assumed one, in variances
  double angle_rad = 0.0;           ///< at time_s
  double window_radps = 0.0;
  double interval_s = 0.0;  ///< the shortest between two readings
  bool near_limit = false;  ///< so near the window's limit that a turn the other way is as likely
  /// Spins that explain them as well, within the window and beyond it up to SpinSearch::fastest_radps.
  std::vector<double> alternatives_radps;
  std::vector<double> residual_rad;  ///< per reading, at the likeliest decay
  std::vector<double> leverage;      ///< per reading: share of its own in its fitted angle
};

/// A rim so fast tears: the hoop stress, density times its square, is 11 MPa in rubber of 1,100 kg/m^3, about
/// its strength.
inline constexpr double kTearingRim_mps = 100.0;

/// Which spins to try.
struct SpinSearch {
  /// Between any two images of the ball that the flash train made, whether they show an equator or not.
  double shortest_interval_s = std::numeric_limits<double>::infinity();
  /// The ball is taken to spin no faster, unless its readings leave nothing else. Their own window is
  /// searched in any case.
  double fastest_radps = 0.0;
  /// What friction of the air takes of the spin, domega/dt over -omega: AirLaw::spin_decay_per_m times the
  /// speed.
  double decay_per_s = 0.0;
  double decay_sd_per_s = 0.0;
  /// It cannot spin faster. Up to fastest_radps: no more is looked for.
  double possible_radps = 0.0;
};

/// The most likely spin within the window |omega| < pi / (2 T), T being the shortest interval of the train or
/// between two readings: an image without an equator does not make the ball turn slower. Each pair of
/// neighbours proposes all spins of the window that it allows; each proposal is followed outward image by
/// image, so that noise over a long leg cannot lose a half turn; the likeliest one is kept, by a cost that
/// one bad reading cannot dominate. The spin decays exponentially: the angle is a straight line over (1 -
/// exp(-decay t)) / decay. That rate is known to a factor of three only: neither the spin nor what else
/// explains the readings need decay at it, and residuals are what it leaves unexplained. Returns nullopt for
/// fewer than two readings. Readings are in order of time, times differ.
///
/// `left_out`: readings whose image did not fit its leg. The line does not go through them, but they count
/// for T and for the cost: with every second image left out the others alone could not tell half a turn more.
std::optional<SpinFit> fit_spin(const std::vector<EquatorReading>& readings,
                                const std::vector<EquatorReading>& left_out = {},
                                const SpinSearch& search = {});

/// Another spin, and by how much its chi squared is larger than that of the spin as fitted.
struct OtherSpin {
  double omega_radps = 0.0;
  double excess = 0.0;
  bool probable = true;  ///< it explains the readings without another decay than the assumed one
};

/// Turns more in the shortest interval than `search.fastest_radps` has, as far as `search.possible_radps`:
/// those whose excess is below kComparableSpins. `fit` as fit_spin returned it for the same readings.
std::vector<OtherSpin> faster_spins(const std::vector<EquatorReading>& readings,
                                    const std::vector<EquatorReading>& left_out, const SpinSearch& search,
                                    const SpinFit& fit);

/// Spins whose chi squared differs by less than 3 sd are indistinguishable.
inline constexpr double kComparableSpins = 9.0;
/// By so much less, 4.5 sd, a spin is believed that no ball is known to have.
inline constexpr double kFarBetter = 20.0;

/// In a time that runs slower as the spin decays, as the spin is fitted: the angle is straight in it.
std::vector<EquatorReading> stretched(std::vector<EquatorReading> readings, double from_s,
                                      double decay_per_s);

}  // namespace strobe::reduction
