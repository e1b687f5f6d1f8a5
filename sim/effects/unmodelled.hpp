// What no model of the simulator has, each with a bound of what it could change at most, reckoned from the
// scene's fastest ball. Pure; thread-safe; allocates.
//
// With q = density·pi·R²/(2·mass), v the largest speed, T the longest dwell time, t how long a leg is seen, V
// the ball's volume:
//   drag_in_contact       v by q·C_D·v²·T
//   lift_in_contact       v by q·v²·T/2 (C_L is at most 1/2)
//   spin_decay_in_contact the spin by c·v·|omega|·T
//   flattening_in_drag    v by q·C_D·v²·T times the depth over the radius, |vy|·T/(pi·R): by so much, at
//   most, is a
//                         flattened ball wider
//   buoyancy              v by density·V/m·g·t
//   air_moved_along       v by half of density·V/m (the added mass of a sphere) times (g + q·C_D·v²)·t
//   earth_rotation        v by 2·7.29e-5/s·v·t (Coriolis)
//   weight_along_plate    contact = "grip" on an inclined plate only: vx by g·|sin|·T; that law's pulse is
//   the net force
// Not bounded by anything that a scene says, hence not listed: wind, what the plate gives way, the ball's
// ringing after it has left, spin about other axes.
#pragma once

#include <string_view>
#include <vector>

#include "common/reduction/readout.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

struct UnmodelledTerm {
  std::string_view name;
  reduction::Quantity quantity;  ///< that it changes most
  double bound = 0.0;            ///< in the quantity's unit, > 0
};

/// Those that the scene's settings do not make 0.
std::vector<UnmodelledTerm> unmodelled_terms(const Scene& scene);

}  // namespace strobe::sim
