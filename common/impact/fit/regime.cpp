#include "common/impact/fit/regime.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/impact/fit/rebound_model.hpp"

namespace strobe::impact {

namespace {

using Eigen::Index;

/// Enough to make any contact grip, and for ode within its range.
double any_friction(ReboundModel model) { return model == ReboundModel::ode ? 1e2 : 1e9; }

constexpr double kSure = 2.0;  ///< sds, as for the regime of a readout

/// The model's friction and slip for given inputs.
struct Prediction {
  double needed = 0.0;
  double available = 0.0;
  double slip_lo = 0.0;

  double margin() const { return needed - available; }
};

Prediction predict(ReboundModel model, const ParameterValues& parameters, double diameter_m,
                   const ModelInputs& in) {
  ParameterValues frictional = parameters;
  frictional[index(Parameter::mu)] = any_friction(model);
  const auto gripping = rebound_of(model, frictional, diameter_m, in);
  const auto actual = rebound_of(model, parameters, diameter_m, in);
  return {.needed = std::abs(gripping->lift_off.vx_mps - in.touchdown.vx_mps),
          .available = parameters[index(Parameter::mu)] * (1.0 + in.e) * std::abs(in.touchdown.vy_mps),
          .slip_lo = actual->slip_lo_mps};
}

/// Sums variances of the margin and of the slip.
struct Variances {
  double margin = 0.0;
  double slip_lo = 0.0;
};

void add_inputs(const Observation& o, ReboundModel model, const ParameterValues& values, double diameter_m,
                Variances& sum) {
  for (std::size_t which = 0; which < input_count(model); ++which) {
    const Prediction more = predict(model, values, diameter_m, moved_inputs(model, o, which, 1.0));
    const Prediction less = predict(model, values, diameter_m, moved_inputs(model, o, which, -1.0));
    sum.margin += std::pow(0.5 * (more.margin() - less.margin()), 2);
    sum.slip_lo += std::pow(0.5 * (more.slip_lo - less.slip_lo), 2);
  }
}

/// Moves the parameters along the principal axes of their correlation by one standard deviation either way,
/// clamped to their bounds.
void add_parameters(const ModelInputs& in, ReboundModel model, const ModelFit& fit,
                    const ParameterValues& values, double diameter_m, Variances& sum) {
  using Square = Eigen::Matrix<double, kParameterCount, kParameterCount>;
  using Vector = Eigen::Matrix<double, kParameterCount, 1>;
  const Vector sd = fit.covariance.diagonal().cwiseSqrt();
  const Vector inverse = (sd.array() > 0.0).select(sd.cwiseInverse(), 0.0);
  const Square correlation = inverse.asDiagonal() * fit.covariance * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(correlation);  // as elsewhere: compiled once
  assert(axes.eigenvalues().minCoeff() > -1e-6);
  const auto moved = [&](Index axis, double sign) {
    const Vector step = sd.cwiseProduct(axes.eigenvectors().col(axis)) *
                        (sign * std::sqrt(std::max(axes.eigenvalues()[axis], 0.0)));
    ParameterValues out = values;
    for (std::size_t i = 0; i < kParameterCount; ++i) {
      const auto p = static_cast<Parameter>(i);
      if (!(sd[static_cast<Index>(i)] > 0.0)) continue;
      const double at = coordinate_of(model, p, out[i]);
      const double to = value_at(model, p, at + step[static_cast<Index>(i)] / slope_at(model, p, at));
      out[i] = std::clamp(to, lower_bound(p), upper_bound(p, 0.5 * diameter_m));
    }
    return out;
  };
  for (Index axis = 0; axis < static_cast<Index>(kParameterCount); ++axis) {
    const Prediction more = predict(model, moved(axis, 1.0), diameter_m, in);
    const Prediction less = predict(model, moved(axis, -1.0), diameter_m, in);
    sum.margin += std::pow(0.5 * (more.margin() - less.margin()), 2);
    sum.slip_lo += std::pow(0.5 * (more.slip_lo - less.slip_lo), 2);
  }
}

/// vx and omega taken as independent.
void add_measured(const Observation& o, double alpha, double radius, RegimeClassification& out) {
  const double share = alpha / (1.0 + alpha);
  const double slip = o.touchdown.vx_mps + radius * o.touchdown.omega_radps;
  const double sign = slip < 0.0 ? -1.0 : 1.0;
  out.slip_lo_mps = o.lift_off.vx_mps + radius * o.lift_off.omega_radps;
  out.slip_lo_sd_mps = std::hypot(o.lift_off_sd.vx_mps, radius * o.lift_off_sd.omega_radps);
  out.shortfall_mps = short_of_rolling_mps(slip, o.touchdown.vx_mps - o.lift_off.vx_mps, alpha);
  out.shortfall_sd_mps = std::hypot((1.0 - share) * o.touchdown_sd.vx_mps, o.lift_off_sd.vx_mps,
                                    share * radius * o.touchdown_sd.omega_radps);
  if (out.shortfall_mps <= 0.0)
    out.measured = Regime::grips;
  else if (sign * out.slip_lo_mps > kSure * out.slip_lo_sd_mps)
    out.measured = Regime::slides;
}

/// The rule of RegimeClassification, with the regime that the predicted velocities tell. Friction that is
/// undetermined says nothing for sure.
void reconcile(Regime told, RegimeClassification& r) {
  r.regime = r.measured == told ? told : r.predicted;
  if (r.measured == Regime::unclear || r.measured == r.regime) return;
  const bool model_unsure = !r.z || std::abs(*r.z) < kSure;
  const bool measurement_unsure = std::abs(r.shortfall_mps) < kSure * r.shortfall_sd_mps;
  if (measurement_unsure) r.measured = Regime::unclear;
  if (model_unsure || !measurement_unsure) r.regime = Regime::unclear;
}

}  // namespace

tl::expected<RegimeClassification, InputError> classify_regime(const Observation& observation,
                                                               ReboundModel model, const ModelFit& fit,
                                                               double diameter_m) {
  ParameterValues values = fit.values();
  const bool friction_known = fit.parameters[index(Parameter::mu)].status != ParameterStatus::undetermined;
  if (!friction_known) values[index(Parameter::mu)] = any_friction(model);
  const ModelInputs in = inputs_of(observation);
  const auto rebound = rebound_of(model, values, diameter_m, in);
  if (!rebound) return tl::unexpected(rebound.error());
  if (const auto error = moved_inputs_error(model, values, diameter_m, observation))
    return tl::unexpected(*error);
  if (!std::isfinite(observation.lift_off.vx_mps) || !std::isfinite(observation.lift_off.omega_radps))
    return tl::unexpected(InputError::not_finite);
  const Prediction predicted = predict(model, values, diameter_m, in);
  Variances variances;
  add_inputs(observation, model, values, diameter_m, variances);
  add_parameters(in, model, fit, values, diameter_m, variances);

  RegimeClassification out;
  out.name = observation.name;
  out.predicted = rebound->regime;
  out.friction_needed_mps = predicted.needed;
  if (friction_known) {
    out.friction_available_mps = predicted.available;
    out.margin_sd_mps = std::sqrt(variances.margin);
    out.z = z_score(predicted.margin(), *out.margin_sd_mps);
    out.probability_slides = 0.5 * std::erfc(-*out.z / std::sqrt(2.0));
  }
  out.slip_lo_predicted_mps = predicted.slip_lo;
  out.slip_lo_predicted_sd_mps = std::sqrt(variances.slip_lo);
  add_measured(observation, values[index(Parameter::alpha)], 0.5 * diameter_m, out);
  const ball::Ball ball{.diameter_m = diameter_m, .alpha = values[index(Parameter::alpha)]};
  reconcile(regime_of(ball, in.touchdown, *rebound), out);
  return out;
}

}  // namespace strobe::impact
