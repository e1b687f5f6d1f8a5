#include "common/impact/fit/model_fit.hpp"

#include <cmath>

#include "common/impact/fit/fit_checks.hpp"
#include "common/impact/fit/fitter.hpp"
#include "common/impact/fit/friction_evidence.hpp"
#include "common/impact/fit/posterior_summary.hpp"
#include "common/impact/fit/uncertainty.hpp"

namespace strobe::impact {

tl::expected<ModelFit, FitFailure> fit(std::span<const Observation> observations, const FitOptions& options) {
  if (const auto failure = find_failure(observations, options)) return tl::unexpected(*failure);
  Fitter fitter(observations, options);
  const bool has_prior = options.model == ReboundModel::ode;
  has_prior ? fitter.search_with_prior() : fitter.search();
  ModelFit out;
  out.converged = fitter.converged();
  out.comparisons = compare(observations, options.model, fitter.values(), options.diameter_m);
  out.statistics = residual_statistics(out.comparisons);
  out.chi2 = fitter.chi2();
  out.clusters = static_cast<int>(fitter.clusters().size());
  out.dof = fitter.degrees_of_freedom();
  if (options.scale != CovarianceScale::stated) out.variance_scale = fitter.reduced(out.chi2, out.dof);
  out.covariance.setZero();
  for (std::size_t i = 0; i < kParameterCount; ++i) out.parameters[i].value = fitter.values()[i];
  if (has_prior) {
    add_posterior(fitter, out);
    return out;
  }
  for (const Parameter p : {Parameter::mu, Parameter::e_x}) {
    FittedParameter& parameter = out.parameters[index(p)];
    parameter.limit = parameter.lower = limit_without_evidence(fitter, p);
    if (parameter.limit) parameter.status = ParameterStatus::undetermined;
  }
  if (const auto added = add_uncertainty(fitter, out); !added) return tl::unexpected(added.error());
  return out;
}

FitOptions default_options(ReboundModel model) {
  FitOptions out{.model = model, .start = default_values(model), .free = {}};
  if (model == ReboundModel::ode) {
    for (std::size_t i = 0; i < kParameterCount; ++i)
      out.free[i] = has_parameter(model, static_cast<Parameter>(i));
    return out;
  }
  out.free[index(Parameter::mu)] = true;
  out.free[index(Parameter::e_x)] = model != ReboundModel::slide_roll;
  out.free[index(Parameter::offset_m)] = model == ReboundModel::grip_offset;
  out.free[index(Parameter::offset_reference_mps)] = model == ReboundModel::grip_offset;
  return out;
}

ParameterValues ModelFit::values() const {
  ParameterValues out{};
  for (std::size_t i = 0; i < kParameterCount; ++i) out[i] = parameters[i].value;
  return out;
}

double ModelFit::correlation(Parameter a, Parameter b) const {
  const auto i = static_cast<Eigen::Index>(index(a));
  const auto j = static_cast<Eigen::Index>(index(b));
  const double scale = std::sqrt(covariance(i, i)) * std::sqrt(covariance(j, j));
  return scale > 0.0 ? covariance(i, j) / scale : 0.0;
}

}  // namespace strobe::impact
