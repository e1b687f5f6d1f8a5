// The rebound models as functions of parameters that can be fitted. Pure, no allocation: thread-safe,
// real-time safe.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <tl/expected.hpp>

#include "common/impact/fit/observation.hpp"

namespace strobe::impact {

enum class ReboundModel {
  slide_roll,   ///< rigid() (Brody): mu, alpha
  grip,         ///< tangential restitution of a grip: mu, e_x, alpha
  grip_offset,  ///< with the normal force ahead of the centre too: mu, e_x, d, u0, alpha
};

enum class Parameter { mu, e_x, offset_m, offset_reference_mps, alpha };
inline constexpr std::size_t kParameterCount = 5;

/// In the order of Parameter; SI units.
using ParameterValues = std::array<double, kParameterCount>;

constexpr std::size_t index(Parameter p) { return static_cast<std::size_t>(p); }

constexpr std::string_view name(ReboundModel model) {
  constexpr std::array<std::string_view, 3> names{"slide-roll", "grip", "grip-offset"};
  return names[static_cast<std::size_t>(model)];
}

constexpr std::string_view name(Parameter p) {
  constexpr std::array<std::string_view, kParameterCount> names{"mu", "ex", "d", "u0", "alpha"};
  return names[index(p)];
}

constexpr bool has_parameter(ReboundModel model, Parameter p) {
  if (p == Parameter::mu || p == Parameter::alpha) return true;
  return model == ReboundModel::grip_offset || (model == ReboundModel::grip && p == Parameter::e_x);
}

/// Closed ranges of the parameters: mu 0…10, e_x -1…1, d 0…R (less a rounding), u0 1e-9…100 m/s, alpha
/// 0.01…2/3.
double lower_bound(Parameter p);
double upper_bound(Parameter p, double radius_m);

/// Start of a fit, and value of a parameter that is not fitted: mu .55, alpha 2/3 and otherwise 0 for
/// slide_roll, kFittedToThesis and kMeasuredAlpha for the others.
ParameterValues default_values(ReboundModel model);

/// Lift-off by the model; parameters that it does not have are ignored. Errors as for grip().
tl::expected<Rebound, InputError> rebound_of(ReboundModel model, const ParameterValues& parameters,
                                             double diameter_m, const Motion& touchdown, double e);

/// The uncertain inputs of an observation: vx, vy, omega at touchdown, and e.
struct ModelInputs {
  Motion touchdown;
  double e = 0.0;
};
inline constexpr std::size_t kInputCount = 4;

/// The observation's inputs with one of them (0…3) moved by a number of its standard deviations and clamped
/// to its valid range.
ModelInputs moved_inputs(const Observation& observation, std::size_t which, double standard_deviations);

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
