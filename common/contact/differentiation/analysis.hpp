// What the images in contact say: the integration approach (damped sine pulse held against the images) and
// the differentiation approach (cubics through the fractions; differentiation.hpp makes velocities and forces
// of them). Pure; thread-safe; allocates.
#pragma once

#include <optional>

#include "common/contact/differentiation/cubic_fit.hpp"
#include "common/data/contact_set.hpp"
#include "common/impact/closed_form/sine_pulse.hpp"

namespace strobe::contact {

struct Inputs {
  double vx_td_mps = 0.0;
  double vy_td_mps = 0.0;  ///< < 0
  double e = 0.0;          ///< see impact::damping_from_restitution
  double mu = 0.0;         ///< impulse ratio; negative where the surface drove the ball forward
  double dwell_time_s = 0.0;
  double dwell_distance_m = 0.0;  ///< > 0, along the surface
  double diameter_m = ball::kThesisDiameter_m;
  impact::PulseForm form = impact::PulseForm::exact;
};

/// Standard error of estimate sqrt(sum (Y - Y')²/(N - 1)) of the pulse against the images between the end
/// points. Along the surface: x fraction · dwell distance; normal to it: y fraction · diameter.
struct Estimate {
  double see_x_m = 0.0;
  double see_y_m = 0.0;
  int n = 0;  ///< images between the end points
  double damping_f = 0.0;
};

/// Fails on inputs out of range, and on fewer than two images between the end points. An image after lift-off
/// (time fraction above 1) is held against the continued formula.
Result<Estimate> estimate_error(const ContactSet& set, const Inputs& inputs);

/// Cubics of each fraction on the time fraction over all rows, the end points included; rows without a
/// rotation are left out of that fit. Absent: the rows do not determine it.
struct FractionFits {
  std::optional<CubicFit> x;
  std::optional<CubicFit> y;
  std::optional<CubicFit> rotation;
};

FractionFits fit_fractions(const ContactSet& set);

/// What turns fractions per time fraction into velocities and forces.
struct Scale {
  double dwell_time_s = 0.0;  ///< > 0
  double dwell_distance_m = 0.0;
  double total_rotation_rad = 0.0;  ///< angle at lift-off less that at touchdown
  double diameter_m = ball::kThesisDiameter_m;
  double mass_kg = ball::kThesisMass_kg;
  double alpha = ball::kMeasuredAlpha;  ///< for the torque only

  double inertia_kgm2() const {
    return ball::Ball{.diameter_m = diameter_m, .mass_kg = mass_kg, .alpha = alpha}.inertia_kgm2();
  }
};

}  // namespace strobe::contact
