// The rebound models as functions of parameters that can be fitted. Pure, no allocation: thread-safe,
// real-time safe.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <tl/expected.hpp>

#include "common/impact/fit/observation.hpp"
#include "common/impact/ode/contact_ode.hpp"

namespace strobe::impact {

enum class ReboundModel {
  slide_roll,   ///< rigid() (Brody): mu, alpha
  grip,         ///< tangential restitution of a grip: mu, e_x, alpha
  grip_offset,  ///< with the normal force ahead of the centre too: mu, e_x, d, u0, alpha
  ode,          ///< the contact mechanics (ode/contact_ode.hpp): mu, u0, alpha and the last four of Parameter
};

enum class Parameter {
  mu,
  e_x,
  offset_m,
  offset_reference_mps,
  alpha,
  stiffness_ratio,
  damping_ratio,
  offset_share,
  dwell_s,  ///< of the observations whose dwell time was not measured
};
inline constexpr std::size_t kParameterCount = 9;

/// In the order of Parameter; SI units.
using ParameterValues = std::array<double, kParameterCount>;

constexpr std::size_t index(Parameter p) { return static_cast<std::size_t>(p); }

constexpr std::string_view name(ReboundModel model) {
  constexpr std::array<std::string_view, 4> names{"slide-roll", "grip", "grip-offset", "ode"};
  return names[static_cast<std::size_t>(model)];
}

constexpr std::string_view name(Parameter p) {
  constexpr std::array<std::string_view, kParameterCount> names{
      "mu", "ex", "d", "u0", "alpha", "stiffness_ratio", "damping_ratio", "offset_share", "dwell"};
  return names[index(p)];
}

constexpr bool has_parameter(ReboundModel model, Parameter p) {
  if (model == ReboundModel::ode) return p != Parameter::e_x && p != Parameter::offset_m;
  if (p > Parameter::alpha) return false;
  if (p == Parameter::mu || p == Parameter::alpha) return true;
  return model == ReboundModel::grip_offset || (model == ReboundModel::grip && p == Parameter::e_x);
}

/// Closed ranges of the parameters: mu 0…10, e_x -1…1, d 0…R (less a rounding), u0 1e-9…100 m/s, alpha
/// 0.01…2/3, stiffness and damping ratio 0.01…100 and 0.01…10, the offset's share 0…1, dwell time 0.1…100 ms.
double lower_bound(Parameter p);
double upper_bound(Parameter p, double radius_m);

/// Start of a fit, and value of a parameter that is not fitted: mu .55, alpha 2/3 and otherwise 0 for
/// slide_roll, kFittedToThesis and kMeasuredAlpha for grips, ContactCoefficients and kContactAlpha for ode.
ParameterValues default_values(ReboundModel model);

/// The uncertain inputs of an observation: vx, vy, omega at touchdown, e, and for ode the dwell time.
struct ModelInputs {
  Motion touchdown;
  double e = 0.0;
  double dwell_s = 0.0;  ///< 0: the parameter's
  double gravity_mps2 = 0.0;
  double gravity_along_mps2 = 0.0;
};
ModelInputs inputs_of(const Observation& observation);

/// Below what a fit to measured shots can notice, by a factor of ten thousand and more.
inline constexpr double kContactFitTolerance = 1e-5;

/// What the contact mechanics is given for ode.
struct ContactInputs {
  ball::Ball ball;
  ContactCoefficients coefficients;
  ContactOptions options;
  double share_until_release = 1.0;  ///< coefficients' dwell time over the measured one
};
ContactInputs contact_inputs(const ParameterValues& parameters, double diameter_m, const ModelInputs& inputs);

constexpr std::size_t input_count(ReboundModel model) { return model == ReboundModel::ode ? 5 : 4; }

/// Lift-off by the model; parameters that it does not have are ignored. Errors as for grip(), or lift_off().
tl::expected<Rebound, InputError> rebound_of(ReboundModel model, const ParameterValues& parameters,
                                             double diameter_m, const ModelInputs& inputs);
inline tl::expected<Rebound, InputError> rebound_of(ReboundModel model, const ParameterValues& parameters,
                                                    double diameter_m, const Motion& touchdown, double e) {
  return rebound_of(model, parameters, diameter_m, ModelInputs{.touchdown = touchdown, .e = e});
}

/// The observation's inputs with one of them moved by a number of its standard deviations and clamped to its valid range.
/// For ode e follows vy at touchdown, of which and of vy at lift-off it is made, where e's sd allows that.
ModelInputs moved_inputs(ReboundModel model, const Observation& observation, std::size_t which,
                         double standard_deviations);

/// The error of the model when each input is moved by one standard deviation either way: an sd that is not
/// finite or too large. Returns nullopt if there is none.
std::optional<InputError> moved_inputs_error(ReboundModel model, const ParameterValues& parameters,
                                             double diameter_m, const Observation& observation);

/// The inputs' uncertainty propagated to (vx, R·omega) at lift-off: variances and covariance, (m/s)². Each
/// input contributes half the difference between one standard deviation above and below (a secant, since the
/// border of the regimes is a kink).
struct InputCovariance {
  double vx = 0.0;
  double spin = 0.0;
  double cross = 0.0;
};

/// Precondition: rebound_of() has a value for this observation and moved_inputs_error() returns nullopt.
InputCovariance input_covariance(ReboundModel model, const ParameterValues& parameters, double diameter_m,
                                 const Observation& observation);

}  // namespace strobe::impact
