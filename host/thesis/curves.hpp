// Curves through the contact for one set, by each approach, in the figures' units. Pure; thread-safe.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/contact/analysis.hpp"
#include "common/contact/condition_inputs.hpp"
#include "common/contact/integration.hpp"
#include "host/thesis/material.hpp"
#include "host/thesis/plot.hpp"

namespace strobe::report {

/// What is drawn over time. Units: ms; cm, mm, degrees; m/s, rad/s; N.
enum class Quantity { x_cm, y_mm, rotation_deg, vx_mps, vy_mps, omega_radps, slip_mps, fx_n, fy_n };

const char* axis_label(Quantity quantity);

struct SetCurves {
  const thesis::Condition* condition = nullptr;
  const contact::ContactSet* set = nullptr;
  double dwell_ms = 0.0;
  double total_rotation_rad = 0.0;  ///< by contact::end_spin_total()
  contact::FractionFits fits;
  contact::Scale scale;
};

/// Fails where the images or the means do not allow the analysis.
Result<SetCurves> set_curves(const Material& material, const std::string& set);

/// Number of steps of a curve from touchdown to lift-off.
inline constexpr int kCurveSteps = 120;

/// Images between the end points, with one residual sd about the cubic as bar; only for x, y and rotation.
std::vector<PlotPoint> measured(const SetCurves& curves, Quantity quantity);

/// The means at touchdown and lift-off with their printed sd; only for velocities, spin and slip.
std::vector<PlotPoint> measured_ends(const SetCurves& curves, Quantity quantity);

/// Cubic through the images, and its derivatives.
std::vector<PlotPoint> differentiated(const SetCurves& curves, Quantity quantity);

/// The damped sine pulse carried through to spin; with the band that the printed sds give, if asked for.
std::vector<PlotPoint> integrated(const SetCurves& curves, impact::PulseForm form, Quantity quantity,
                                  bool band);

}  // namespace strobe::report
