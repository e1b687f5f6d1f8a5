// The rebound models as functions of parameters that can be fitted. Pure, no allocation: thread-safe,
// real-time safe.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

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

/// The observation's inputs with one of them moved by a number of its standard deviations and clamped to its
/// valid range. For ode e follows vy at touchdown, of which and of vy at lift-off it is made, where e's sd
/// allows that.
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

// What is known of the contact mechanics' coefficients before any shot: normal distributions of a coordinate
// that each coefficient may take any value in, the logarithm, or the logit of its place in its range. Weak:
// 95 % of the prior of mu is 0.13…2. A laboratory's shots outweigh it wherever they tell a coefficient at
// all. Pure; thread-safe, real-time safe.
//
//   coefficient      range       median   sd of the coordinate   95 %               from
//   mu               0…          0.5      0.7 (log)              0.13…2.0           ball on court surfaces:
//   .3 to .9 u0               0…          5 m/s    1.2 (log)              0.48…53 m/s        nothing but the
//   size of speeds stiffness_ratio  0…          1        1.0 (log)              0.14…7.1           Mindlin:
//   2/3 to 1 for a solid sphere damping_ratio    0…          0.5      1.0 (log)              0.07…3.5
//   critical damping is 2·sqrt(alpha/(1 + alpha)) offset_share     0…1         0.12     1.2 (logit)
//   0.013…0.59         less than the footprint's radius alpha            0.4…2/3     0.55     1.5 (logit)
//   0.416…0.656        solid ball…thin shell; Cross: 0.55 dwell            0…          4.7 ms   0.25 (log)
//   2.9…7.7 ms         tennis balls on hard surfaces: 4 to 6

/// Of the coordinate.
struct Prior {
  double mean = 0.0;
  double sd = 1.0;
};

/// Returns nullopt for the closed forms, whose parameters are fitted by the data alone.
std::optional<Prior> prior_of(ReboundModel model, Parameter parameter);

/// The coordinate in which a parameter is fitted; the value itself for the closed forms. A value at the end
/// of its range or beyond counts as just within it.
double coordinate_of(ReboundModel model, Parameter parameter, double value);
double value_at(ReboundModel model, Parameter parameter, double coordinate);
/// Derivative of the value by the coordinate.
double slope_at(ReboundModel model, Parameter parameter, double coordinate);

/// The prior's quantile of the value, `sds` from its median.
double prior_value(Parameter parameter, double sds);

// The lift-off of the contact mechanics and its derivatives by the coefficients. Pure; thread-safe, real-time
// safe.

/// Of vx and R·omega at lift-off, m/s for each unit of the parameter.
struct ContactGradient {
  std::array<double, kParameterCount> vx{};
  std::array<double, kParameterCount> spin{};
};

/// 0 for the parameters that ode does not have, and for the dwell time where the inputs have their own.
/// Errors as for rebound_of().
tl::expected<ContactGradient, InputError> contact_gradient(const ParameterValues& parameters,
                                                           double diameter_m, const ModelInputs& inputs);

// Measured rebounds compared with a rebound model's predictions. Pure; thread-safe; compare() allocates.

/// One observation and its prediction. Residual: measured less predicted.
struct Comparison {
  Rebound predicted;
  double vx_residual_mps = 0.0;
  double omega_residual_radps = 0.0;
  std::optional<double> z_vx;  ///< residual over the lift-off's stated sd; absent if that is 0
  std::optional<double> z_omega;
  /// Over the sd of lift-off and of the prediction from touchdown and e (not from the parameters).
  std::optional<double> z_vx_with_inputs;
  std::optional<double> z_omega_with_inputs;
};

/// Over several comparisons; absent z-scores are left out.
struct ResidualStatistics {
  double rms_vx_mps = 0.0;
  double rms_omega_radps = 0.0;
  int count = 0;
  int within_sd_vx = 0;  ///< |z| <= 1
  int within_sd_omega = 0;
  double rms_z_vx = 0.0;
  double rms_z_omega = 0.0;
};

ResidualStatistics residual_statistics(std::span<const Comparison> comparisons);

/// Compares observations with a model of given parameters. Precondition: inputs that fit() accepts.
std::vector<Comparison> compare(std::span<const Observation> observations, ReboundModel model,
                                const ParameterValues& parameters, double diameter_m);

}  // namespace strobe::impact
