// How the air acts on a kind of ball: coefficients of drag, lift and the spin's decay, with their tolerances.
// The defaults are a used tennis ball's: C_D in flight is 0.51 (Cross, Lindsey 2013) to 0.65 (Mehta, Alam,
// Subic 2008, new felt), which lie within two standard deviations; lifts by several authors scatter by a
// fifth about C_L = 1 / (2 + v / (R |omega|)) (Stepanek 1988, in the form of Cross; Cross, Lindsey 2013); the
// spin's decay, .05 % in 3 ms at 17 m/s, is known in its order only: felt and seam decide it. Plain values;
// thread-safe, real-time safe.
#pragma once

#include <array>
#include <string_view>

namespace strobe::flight {

/// C_D is constant over the speeds from least_mps to most_mps; C_L = S / (lift_offset + lift_slope S) with
/// the spin ratio S = R |omega| / v, which is Stepanek's (1988) for tennis balls (1, 2) and Nathan's (Am. J.
/// Phys. 76, 119, 2008) for baseballs (0.4, 2.32); lift_offset 0: no lift.
struct AirLaw {
  double drag_coefficient = 0.55;     ///< 0 to 2
  double drag_coefficient_sd = 0.05;  ///< over balls, wear and, within the range, speed
  double lift_offset = 1.0;           ///< >= 0
  double lift_slope = 2.0;            ///< > 0
  double lift_share_sd = 0.2;         ///< of the lift coefficient, as a share of it
  double spin_decay_per_m = 0.01;     ///< domega/dt = -spin_decay_per_m |v| omega in air of 1.204 kg/m^3
  double spin_decay_sd_per_m = 0.005;
  double least_mps = 0.0, most_mps = 70.0;  ///< for which the coefficients were measured

  /// Of the drag, as a share of it; 0 without drag.
  constexpr double drag_share_sd() const {
    return drag_coefficient > 0.0 ? drag_coefficient_sd / drag_coefficient : 0.0;
  }
  /// Lift coefficient of a ball that does nothing but spin.
  constexpr double greatest_lift() const { return lift_offset > 0.0 ? 1.0 / lift_slope : 0.0; }

  bool operator==(const AirLaw&) const = default;
};

/// Its fields as files and messages name them, with what is valid; least_mps must not be above most_mps.
struct AirLawField {
  std::string_view name;
  double AirLaw::*member;
  double least, most;
};
inline constexpr std::array<AirLawField, 9> kAirLawFields{
    {{"drag_coefficient", &AirLaw::drag_coefficient, 0.0, 2.0},
     {"drag_coefficient_sd", &AirLaw::drag_coefficient_sd, 0.0, 1.0},
     {"lift_offset", &AirLaw::lift_offset, 0.0, 100.0},
     {"lift_slope", &AirLaw::lift_slope, 0.1, 100.0},
     {"lift_share_sd", &AirLaw::lift_share_sd, 0.0, 1.0},
     {"spin_decay_per_m", &AirLaw::spin_decay_per_m, 0.0, 1.0},
     {"spin_decay_sd_per_m", &AirLaw::spin_decay_sd_per_m, 0.0, 1.0},
     {"least_mps", &AirLaw::least_mps, 0.0, 200.0},
     {"most_mps", &AirLaw::most_mps, 0.0, 200.0}}};

}  // namespace strobe::flight
