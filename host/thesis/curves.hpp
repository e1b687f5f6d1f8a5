// Curves through the contact for one set, by each approach, in the figures' units. Pure; thread-safe.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/contact/condition_inputs.hpp"
#include "common/contact/constrained_motion.hpp"
#include "common/impact/fit/contact_fit.hpp"
#include "common/impact/ode/contact_trajectory.hpp"
#include "host/figures/figure.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::thesis {

/// Quantities drawn over time, in the units of their names.
enum class Quantity { x_cm, y_mm, rotation_deg, vx_mps, vy_mps, omega_radps, slip_mps, fx_n, fy_n };

const char* axis_label(Quantity quantity);
const char* short_label(Quantity quantity);  ///< for narrow panels
bool is_rotational(Quantity quantity);       ///< rotation, spin and slip

struct SetCurves {
  const thesis::Condition* condition = nullptr;
  const data::ContactSet* set = nullptr;
  double dwell_ms = 0.0;
  contact::FractionFits fits;
  contact::ContactScale scale;
  std::optional<contact::ConstrainedMotion> spline;
  std::optional<impact::ContactTrajectory> mechanics;
};

enum class Approach {
  cubic,             ///< differentiation as in the thesis
  spline,            ///< differentiation with the end velocities given
  pulse_exact,       ///< integration, friction throughout
  pulse_simplified,  ///< the same in the thesis's form
  pulse_grip,        ///< integration with friction until the contact point stops
  mechanics,         ///< the contact ODE fitted to all sets
};

/// Fails if there is no set of that name.
Result<SetCurves> set_curves(const ThesisInputs& inputs, const std::string& set);

/// Number of steps of a curve from touchdown to lift-off.
inline constexpr int kCurveSteps = 120;

/// Images between the end points, with one residual sd about the cubic as bar; only for x, y and rotation.
std::vector<figures::PlotPoint> measured(const SetCurves& curves, Quantity quantity);

/// The means at touchdown and lift-off with their printed sd; only for velocities, spin and slip.
std::vector<figures::PlotPoint> measured_ends(const SetCurves& curves, Quantity quantity);

/// The approach's curve from touchdown to lift-off, optionally with a band of one sd: of the fit for
/// differentiation, of a single shot by the printed sds for integration. Empty where the approach does not
/// have the quantity.
std::vector<figures::PlotPoint> curve(const SetCurves& curves, Approach approach, Quantity quantity,
                                      bool band);

}  // namespace strobe::thesis
