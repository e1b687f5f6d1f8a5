// Whether the spins before and after the bounce can belong together, and whether others could as well. Part
// of the reduction, not of its interface. Pure; thread-safe.
#pragma once

#include <array>
#include <optional>

#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// What friction makes of one bounce: a spin read modulo half a turn between images, wrong by a multiple of
/// pi over the interval, mostly contradicts it.
///
/// With slip s = vx + R·omega, J = vy_LO - vy_TD, and the normal force at most kLargestOffset of the radius
/// beside the centre, whatever the coefficient of friction:
///  - friction turns the ball by as much as it takes from its travel (thesis, eq. 9 to 12):
///    |alpha·R·(omega_LO - omega_TD) - (vx_LO - vx_TD)| <= offset·J, offset as a share of R, alpha from 1/2
///    to 2/3;
///  - it opposes the slip: (vx_LO - vx_TD) has the sign of -s_TD, unless the offset drives it;
///  - it does not make the slip grow, |s_LO| <= |s_TD|, but for what the offset adds;
///  - the bounce adds no energy: v^2 + alpha (R·omega)^2 does not grow;
/// each within kLimit_sd of its numbers' own sd.
class Friction {
 public:
  /// Returns nullopt if a velocity is lacking.
  static std::optional<Friction> of(const Readout& readout, const ShotFit& fit);

  /// By how much the spins at touchdown and lift-off contradict it, together; 0: the bounce can have had
  /// them; infinite: they would need energy from nowhere.
  double contradiction_mps(double omega_td_radps, double omega_lo_radps) const;
  bool allows(double omega_td_radps, double omega_lo_radps) const {
    return contradiction_mps(omega_td_radps, omega_lo_radps) == 0.0;
  }

  /// The same, and with a coefficient of friction that a surface has: a ball that still slips at lift-off
  /// slid throughout, so that its impulse ratio is the coefficient.
  bool likely(double omega_td_radps, double omega_lo_radps) const;

  /// Likewise where one of the spins is not known: for some spin before, no faster than `fastest_radps`, or
  /// after.
  bool likely_before(double omega_td_radps) const;
  bool likely_after(double omega_lo_radps, double fastest_radps) const;

  /// Of the normal force, as a share of the radius. Twice the mean of the thesis's sets, 2.4 ± 0.85 mm
  /// of 32.5.
  static constexpr double kLargestOffset = 0.15;
  /// Chance passes it once in 16,000 shots.
  static constexpr double kLimit_sd = 4.0;
  /// The fastest courts rate CPR 60 in the ITF's scheme, 100(1 - mu) + ..., that is a mu of some 0.4: half of
  /// that.
  static constexpr double kMinFriction = 0.2;

 private:
  /// Of the speed whose kinetic energy is all that the ball has.
  double gain_mps(double omega_td_radps, double omega_lo_radps) const;
  /// By how much the spin may change: at the ends of alpha's range and of the offset's.
  std::array<double, 6> turns_radps() const;
  bool slides_too_easily(double omega_td_radps, double omega_lo_radps) const;

  double radius_m_ = 0.0;
  double least_alpha_ = 0.0;
  double greatest_alpha_ = 0.0;
  double vx_td_mps_ = 0.0;
  double vx_lo_mps_ = 0.0;
  double vy_td_mps_ = 0.0;
  double vy_lo_mps_ = 0.0;
  double impulse_mps_ = 0.0;
  double change_sd_mps_ = 0.0;  ///< of vx_LO - vx_TD
  double rim_sd_mps_ = 0.0;     ///< of R (omega_LO - omega_TD)
};

struct SpinCheck {
  /// The readings allow other spins (SpinFit::alternatives_radps) that friction allows too, or that
  /// contradict it less than those fitted do; or those fitted contradict it by so much that only a turn more
  /// explains it: images cannot tell a turn more between two flashes, whatever the interval.
  bool in_doubt = false;
  /// Spins beyond the assumed limit explain all, and those fitted do not, or are beyond it themselves.
  bool faster = false;
  /// They do so far better (kFarBetter): a fit without the limit finds them.
  bool far_better = false;
  SpinEvidenceSet told_by;  ///< none where in doubt
};

/// Of both legs together. Nothing is said where no spin is known.
SpinCheck check_spins(const Readout& readout, const ShotFit& fit);

}  // namespace strobe::reduction
