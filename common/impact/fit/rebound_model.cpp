#include "common/impact/fit/rebound_model.hpp"

#include <algorithm>
#include <cassert>

namespace strobe::impact {

namespace {

constexpr ParameterValues kLower{0.0, -1.0, 0.0, 1e-9, 0.01};
constexpr double kMaxMu = 10.0;
constexpr double kMaxReference_mps = 100.0;

}  // namespace

double lower_bound(Parameter p) { return kLower[index(p)]; }

double upper_bound(Parameter p, double radius_m) {
  const ParameterValues upper{kMaxMu, 1.0, radius_m * (1.0 - 1e-12), kMaxReference_mps,
                              ball::kThinShellAlpha};
  return upper[index(p)];
}

ParameterValues default_values(ReboundModel model) {
  if (model == ReboundModel::slide_roll)
    return {0.55, 0.0, 0.0, kOffsetReferenceSpeed_mps, ball::kThinShellAlpha};
  const double offset_m = model == ReboundModel::grip_offset ? kFittedToThesis.offset_m : 0.0;
  return {kFittedToThesis.mu, kFittedToThesis.e_x, offset_m, kOffsetReferenceSpeed_mps, ball::kMeasuredAlpha};
}

tl::expected<Rebound, InputError> rebound_of(ReboundModel model, const ParameterValues& parameters,
                                             double diameter_m, const Motion& touchdown, double e) {
  const auto value = [&](Parameter p) { return has_parameter(model, p) ? parameters[index(p)] : 0.0; };
  Coefficients c{.e = e, .mu = value(Parameter::mu), .e_x = value(Parameter::e_x)};
  c.offset_m = value(Parameter::offset_m);
  if (model == ReboundModel::grip_offset) c.offset_reference_mps = value(Parameter::offset_reference_mps);
  return impact::grip({.diameter_m = diameter_m, .alpha = value(Parameter::alpha)}, touchdown, c);
}

ModelInputs moved_inputs(const Observation& o, std::size_t which, double standard_deviations) {
  ModelInputs in{o.touchdown, o.e};
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
  for (std::size_t which = 0; which < kInputCount; ++which) {
    for (const double sign : {1.0, -1.0}) {
      const ModelInputs in = moved_inputs(observation, which, sign);
      const auto moved = rebound_of(model, parameters, diameter_m, in.touchdown, in.e);
      if (!moved) return moved.error();
    }
  }
  return std::nullopt;
}

InputCovariance input_covariance(ReboundModel model, const ParameterValues& parameters, double diameter_m,
                                 const Observation& observation) {
  InputCovariance sum;
  for (std::size_t which = 0; which < kInputCount; ++which) {
    const ModelInputs more = moved_inputs(observation, which, 1.0);
    const ModelInputs less = moved_inputs(observation, which, -1.0);
    const auto high = rebound_of(model, parameters, diameter_m, more.touchdown, more.e);
    const auto low = rebound_of(model, parameters, diameter_m, less.touchdown, less.e);
    assert(high && low);
    const double vx = 0.5 * (high->lift_off.vx_mps - low->lift_off.vx_mps);
    const double spin = 0.25 * diameter_m * (high->lift_off.omega_radps - low->lift_off.omega_radps);
    sum.vx += vx * vx;
    sum.spin += spin * spin;
    sum.cross += vx * spin;
  }
  return sum;
}

}  // namespace strobe::impact
