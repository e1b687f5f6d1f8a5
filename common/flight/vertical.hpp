// How high a ball rises that leaves the surface straight up, and how fast one lands that was dropped, in air:
// dv/dt = -g - k v|v| with the drag k per metre (Aerodynamics::drag_per_m) has the first integrals
//   rise = ln(1 + k v^2/g) / (2k),   speed^2 = g/k (1 - exp(-2k fall)).
// Heights are of one point of the ball, its lowest as standards measure it: from rest or to rest. Left out is
// what the displaced air carries: of hollow balls some 1 % of g (table tennis, basketball 1.5 %). Source: the
// equation of motion, which is linear in v^2 by the height. Pure functions of plain values; thread-safe,
// real-time safe.
#pragma once

#include "common/flight/gravity.hpp"

namespace strobe::flight {

/// A number and its derivatives: by the speed or height that it was made of, and by the drag.
struct VerticalNumber {
  double value = 0.0;
  double by_input = 0.0;
  double by_drag_per_m = 0.0;
};

/// Height in m that a ball rises which leaves with speed_mps >= 0. drag_per_m >= 0; 0: v^2/2g.
VerticalNumber rise_m(double speed_mps, double drag_per_m, double gravity_mps2 = kStandardGravity_mps2);

/// The speed with which a ball leaves that rises height_m >= 0.
VerticalNumber rise_speed_mps(double height_m, double drag_per_m,
                              double gravity_mps2 = kStandardGravity_mps2);

/// Height in m of the fall from rest that ends with speed_mps >= 0. Infinite for a speed that no fall
/// reaches.
VerticalNumber fall_m(double speed_mps, double drag_per_m, double gravity_mps2 = kStandardGravity_mps2);

/// Speed after a fall from rest through height_m >= 0.
VerticalNumber fall_speed_mps(double height_m, double drag_per_m,
                              double gravity_mps2 = kStandardGravity_mps2);

}  // namespace strobe::flight
