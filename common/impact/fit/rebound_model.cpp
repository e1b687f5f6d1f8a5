#include "common/impact/fit/rebound_model.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>

#include "common/impact/ode/contact_sensitivity.hpp"
#include "common/impact/ode/normal_spring.hpp"

namespace strobe::impact {

namespace {

constexpr ParameterValues kLower{0.0, -1.0, 0.0, 1e-9, 0.01, 1e-2, 1e-2, 0.0, 1e-4};
constexpr double kMaxMu = 10.0;
constexpr double kMaxReference_mps = 100.0;
/// Least share of vy and of the dwell time that an input moved by its sd keeps.
constexpr double kMinShare = 1e-3;

/// What is measured is the time until the centre is one radius above the surface again. The ball leaves
/// before, still compressed by 2·zeta/sqrt(k/m) of its speed (normal_spring.hpp).
double share_until_release(double e) {
  const auto zeta = damping_ratio_from_restitution(e);
  return zeta ? 1.0 / (1.0 + 2.0 * *zeta / release_phase(*zeta)) : 1.0;
}

tl::expected<Rebound, InputError> contact_rebound(const ParameterValues& parameters, double diameter_m,
                                                  const ModelInputs& in) {
  const ContactInputs contact = contact_inputs(parameters, diameter_m, in);
  return lift_off(contact.ball, in.touchdown, contact.coefficients, contact.options)
      .map([&](const ContactLiftOff& out) {
        const Motion& td = in.touchdown;
        const double radius = contact.ball.radius_m();
        const double impulse = out.lift_off.vy_mps - td.vy_mps;
        const double lost = td.vx_mps - out.lift_off.vx_mps;
        const double spun = radius * (out.lift_off.omega_radps - td.omega_radps);
        return Rebound{.lift_off = out.lift_off,
                       .regime = out.regime,
                       .slip_lo_mps = out.lift_off.vx_mps + radius * out.lift_off.omega_radps,
                       .impulse_ratio = lost / impulse,
                       .offset_m = radius * (contact.ball.alpha * spun + lost) / impulse};
      });
}

/// e is -vy_LO/vy_TD: of its sd the part that is vy_TD's moves with that, and the rest is vy_LO's own.
ModelInputs moved_contact(const Observation& o, std::size_t which, double standard_deviations) {
  ModelInputs in = inputs_of(o);
  Motion& td = in.touchdown;
  const double with_vy = o.e * o.touchdown_sd.vy_mps / std::abs(td.vy_mps);
  const double own = std::sqrt(std::max(0.0, o.e_sd * o.e_sd - with_vy * with_vy));
  const bool consists = o.e_sd >= with_vy;
  if (which == 0) td.vx_mps += standard_deviations * o.touchdown_sd.vx_mps;
  if (which == 1) {
    td.vy_mps = std::min(kMinShare * td.vy_mps, td.vy_mps + standard_deviations * o.touchdown_sd.vy_mps);
    if (consists) in.e *= o.touchdown.vy_mps / td.vy_mps;
  }
  if (which == 2) td.omega_radps += standard_deviations * o.touchdown_sd.omega_radps;
  if (which == 3) in.e += standard_deviations * (consists ? own : o.e_sd);
  if (which == 4)
    in.dwell_s = std::max(kMinShare * o.dwell_s, o.dwell_s + standard_deviations * o.dwell_sd_s);
  in.e = std::clamp(in.e, std::min(o.e, kMinSpringRestitution), 1.0);
  return in;
}

}  // namespace

ContactInputs contact_inputs(const ParameterValues& parameters, double diameter_m, const ModelInputs& in) {
  const auto value = [&](Parameter p) { return parameters[index(p)]; };
  const double share = share_until_release(in.e);
  return {.ball = {.diameter_m = diameter_m, .alpha = value(Parameter::alpha)},
          .coefficients = {.e = in.e,
                           .dwell_s = share * (in.dwell_s > 0.0 ? in.dwell_s : value(Parameter::dwell_s)),
                           .mu = value(Parameter::mu),
                           .stiffness_ratio = value(Parameter::stiffness_ratio),
                           .damping_ratio = value(Parameter::damping_ratio),
                           .offset_share = value(Parameter::offset_share),
                           .offset_reference_mps = value(Parameter::offset_reference_mps),
                           .gravity_mps2 = in.gravity_mps2,
                           .gravity_along_mps2 = in.gravity_along_mps2},
          .options = {.method = ContactMethod::collocation, .tolerance = kContactFitTolerance},
          .share_until_release = share};
}

double lower_bound(Parameter p) { return kLower[index(p)]; }

double upper_bound(Parameter p, double radius_m) {
  const ParameterValues upper{
      kMaxMu, 1.0, radius_m * (1.0 - 1e-12), kMaxReference_mps, ball::kThinShellAlpha, 1e2, 10.0, 1.0, 0.1};
  return upper[index(p)];
}

ParameterValues default_values(ReboundModel model) {
  if (model == ReboundModel::slide_roll)
    return {0.55, 0.0, 0.0, kOffsetReferenceSpeed_mps, ball::kThinShellAlpha};
  if (model == ReboundModel::ode) {
    const ContactCoefficients c;
    return {c.mu,
            0.0,
            0.0,
            c.offset_reference_mps,
            kContactAlpha,
            c.stiffness_ratio,
            c.damping_ratio,
            c.offset_share,
            c.dwell_s};
  }
  const double offset_m = model == ReboundModel::grip_offset ? kFittedToThesis.offset_m : 0.0;
  return {kFittedToThesis.mu, kFittedToThesis.e_x, offset_m, kOffsetReferenceSpeed_mps, ball::kMeasuredAlpha};
}

tl::expected<Rebound, InputError> rebound_of(ReboundModel model, const ParameterValues& parameters,
                                             double diameter_m, const ModelInputs& in) {
  if (model == ReboundModel::ode) return contact_rebound(parameters, diameter_m, in);
  const auto value = [&](Parameter p) { return has_parameter(model, p) ? parameters[index(p)] : 0.0; };
  Coefficients c{.e = in.e, .mu = value(Parameter::mu), .e_x = value(Parameter::e_x)};
  c.offset_m = value(Parameter::offset_m);
  if (model == ReboundModel::grip_offset) c.offset_reference_mps = value(Parameter::offset_reference_mps);
  return impact::grip({.diameter_m = diameter_m, .alpha = value(Parameter::alpha)}, in.touchdown, c);
}

ModelInputs inputs_of(const Observation& o) {
  return {o.touchdown, o.e, o.dwell_s, o.gravity_mps2, o.gravity_along_mps2};
}

ModelInputs moved_inputs(ReboundModel model, const Observation& o, std::size_t which,
                         double standard_deviations) {
  ModelInputs in = inputs_of(o);
  if (model == ReboundModel::ode) return moved_contact(o, which, standard_deviations);
  Motion& td = in.touchdown;
  if (which == 0) td.vx_mps += standard_deviations * o.touchdown_sd.vx_mps;
  if (which == 1)
    td.vy_mps = std::min(-kMinMagnitude, td.vy_mps + standard_deviations * o.touchdown_sd.vy_mps);
  if (which == 2) td.omega_radps += standard_deviations * o.touchdown_sd.omega_radps;
  if (which == 3) in.e = std::clamp(in.e + standard_deviations * o.e_sd, 0.0, 1.0);
  return in;
}

std::optional<InputError> moved_inputs_error(ReboundModel model, const ParameterValues& parameters,
                                             double diameter_m, const Observation& observation) {
  for (std::size_t which = 0; which < input_count(model); ++which) {
    for (const double sign : {1.0, -1.0}) {
      const auto moved =
          rebound_of(model, parameters, diameter_m, moved_inputs(model, observation, which, sign));
      if (!moved) return moved.error();
    }
  }
  return std::nullopt;
}

InputCovariance input_covariance(ReboundModel model, const ParameterValues& parameters, double diameter_m,
                                 const Observation& observation) {
  InputCovariance sum;
  for (std::size_t which = 0; which < input_count(model); ++which) {
    const auto high = rebound_of(model, parameters, diameter_m, moved_inputs(model, observation, which, 1.0));
    const auto low = rebound_of(model, parameters, diameter_m, moved_inputs(model, observation, which, -1.0));
    assert(high && low);
    const double vx = 0.5 * (high->lift_off.vx_mps - low->lift_off.vx_mps);
    const double spin = 0.25 * diameter_m * (high->lift_off.omega_radps - low->lift_off.omega_radps);
    sum.vx += vx * vx;
    sum.spin += spin * spin;
    sum.cross += vx * spin;
  }
  return sum;
}

namespace {

constexpr double kSolidBallAlpha = 0.4;
constexpr double kMinInside = 1e-9;  ///< of a range, from its end

/// Where `high` is 0 the range has no upper end.
struct Known {
  double low;
  double high;
  double median;
  double sd;
};

constexpr Known known(Parameter p) {
  switch (p) {
    case Parameter::mu:
      return {0.0, 0.0, 0.5, 0.7};
    case Parameter::offset_reference_mps:
      return {0.0, 0.0, 5.0, 1.2};
    case Parameter::damping_ratio:
      return {0.0, 0.0, 0.5, 1.0};
    case Parameter::offset_share:
      return {0.0, 1.0, 0.12, 1.2};
    case Parameter::alpha:
      return {kSolidBallAlpha, ball::kThinShellAlpha, ball::kMeasuredAlpha, 1.5};
    case Parameter::dwell_s:
      return {0.0, 0.0, 4.7e-3, 0.25};
    default:
      return {0.0, 0.0, 1.0, 1.0};  // the stiffness ratio
  }
}

double to_coordinate(const Known& k, double value) {
  if (k.high == 0.0) return std::log(std::max(value, kMinInside * k.median));
  const double inside = kMinInside * (k.high - k.low);
  const double v = std::clamp(value, k.low + inside, k.high - inside);
  return std::log((v - k.low) / (k.high - v));
}

double from_coordinate(const Known& k, double at) {
  if (k.high == 0.0) return std::exp(at);
  return k.low + (k.high - k.low) / (1.0 + std::exp(-at));
}

}  // namespace

std::optional<Prior> prior_of(ReboundModel model, Parameter p) {
  if (model != ReboundModel::ode || !has_parameter(model, p)) return std::nullopt;
  return Prior{to_coordinate(known(p), known(p).median), known(p).sd};
}

double coordinate_of(ReboundModel model, Parameter p, double value) {
  return model == ReboundModel::ode ? to_coordinate(known(p), value) : value;
}

double value_at(ReboundModel model, Parameter p, double coordinate) {
  return model == ReboundModel::ode ? from_coordinate(known(p), coordinate) : coordinate;
}

double slope_at(ReboundModel model, Parameter p, double coordinate) {
  if (model != ReboundModel::ode) return 1.0;
  const Known k = known(p);
  const double value = from_coordinate(k, coordinate);
  return k.high == 0.0 ? value : (value - k.low) * (k.high - value) / (k.high - k.low);
}

double prior_value(Parameter p, double sds) {
  const Known k = known(p);
  return from_coordinate(k, to_coordinate(k, k.median) + sds * k.sd);
}

namespace {

std::optional<ContactInput> input_of(Parameter p) {
  switch (p) {
    case Parameter::mu:
      return ContactInput::mu;
    case Parameter::offset_reference_mps:
      return ContactInput::offset_reference_mps;
    case Parameter::alpha:
      return ContactInput::alpha;
    case Parameter::stiffness_ratio:
      return ContactInput::stiffness_ratio;
    case Parameter::damping_ratio:
      return ContactInput::damping_ratio;
    case Parameter::offset_share:
      return ContactInput::offset_share;
    case Parameter::dwell_s:
      return ContactInput::dwell_s;
    default:
      return std::nullopt;
  }
}

}  // namespace

tl::expected<ContactGradient, InputError> contact_gradient(const ParameterValues& parameters,
                                                           double diameter_m, const ModelInputs& inputs) {
  const ContactInputs contact = contact_inputs(parameters, diameter_m, inputs);
  return lift_off_sensitivity(contact.ball, inputs.touchdown, contact.coefficients, contact.options)
      .map([&](const ContactSensitivity& s) {
        ContactGradient out;
        for (std::size_t i = 0; i < kParameterCount; ++i) {
          const auto p = static_cast<Parameter>(i);
          const auto input = input_of(p);
          const bool is_dwell = p == Parameter::dwell_s;
          if (!input || (is_dwell && inputs.dwell_s > 0.0)) continue;
          const double factor = is_dwell ? contact.share_until_release : 1.0;
          const auto k = static_cast<std::size_t>(*input);
          out.vx[i] = factor * s.vx_mps[k];
          out.spin[i] = factor * contact.ball.radius_m() * s.omega_radps[k];
        }
        return out;
      });
}

namespace {

std::optional<double> z_if_known(double residual, double sd) {
  if (sd > 0.0) return residual / sd;
  return std::nullopt;
}

Comparison compare_one(const Observation& o, ReboundModel model, const ParameterValues& parameters,
                       double diameter_m) {
  const double radius = 0.5 * diameter_m;
  const InputCovariance inputs = input_covariance(model, parameters, diameter_m, o);
  Comparison out;
  out.predicted = *rebound_of(model, parameters, diameter_m, inputs_of(o));
  out.vx_residual_mps = o.lift_off.vx_mps - out.predicted.lift_off.vx_mps;
  out.omega_residual_radps = o.lift_off.omega_radps - out.predicted.lift_off.omega_radps;
  out.z_vx = z_if_known(out.vx_residual_mps, o.lift_off_sd.vx_mps);
  out.z_omega = z_if_known(out.omega_residual_radps, o.lift_off_sd.omega_radps);
  out.z_vx_with_inputs =
      z_if_known(out.vx_residual_mps, std::hypot(o.lift_off_sd.vx_mps, std::sqrt(inputs.vx)));
  out.z_omega_with_inputs = z_if_known(
      out.omega_residual_radps, std::hypot(o.lift_off_sd.omega_radps, std::sqrt(inputs.spin) / radius));
  return out;
}

/// Root mean square of the z-scores present, and how many are within one sd.
struct ZScores {
  int count = 0;
  int within = 0;
  double squares = 0.0;

  void add(const std::optional<double>& z) {
    if (!z) return;
    ++count;
    within += std::abs(*z) <= 1.0 ? 1 : 0;
    squares += *z * *z;
  }
  double rms() const { return count > 0 ? std::sqrt(squares / count) : 0.0; }
};

}  // namespace

std::vector<Comparison> compare(std::span<const Observation> observations, ReboundModel model,
                                const ParameterValues& parameters, double diameter_m) {
  std::vector<Comparison> out;
  out.reserve(observations.size());
  for (const Observation& o : observations) out.push_back(compare_one(o, model, parameters, diameter_m));
  return out;
}

ResidualStatistics residual_statistics(std::span<const Comparison> comparisons) {
  ResidualStatistics out;
  if (comparisons.empty()) return out;
  ZScores vx, omega;
  for (const Comparison& c : comparisons) {
    out.rms_vx_mps += c.vx_residual_mps * c.vx_residual_mps;
    out.rms_omega_radps += c.omega_residual_radps * c.omega_residual_radps;
    vx.add(c.z_vx);
    omega.add(c.z_omega);
  }
  const auto n = static_cast<double>(comparisons.size());
  out.count = static_cast<int>(comparisons.size());
  out.rms_vx_mps = std::sqrt(out.rms_vx_mps / n);
  out.rms_omega_radps = std::sqrt(out.rms_omega_radps / n);
  out.within_sd_vx = vx.within;
  out.within_sd_omega = omega.within;
  out.rms_z_vx = vx.rms();
  out.rms_z_omega = omega.rms();
  return out;
}

}  // namespace strobe::impact
