// What the data of a fit do not tell, in words.
#include <fmt/format.h>

#include <cmath>

#include "common/impact/fit/coefficient_prior.hpp"
#include "host/commands/fit/fit_report.hpp"

namespace strobe::host {

namespace {

using impact::Parameter;

/// A parameter of which the interval is little narrower than what was known before.
std::string about_prior(const impact::Posterior& q, std::size_t i) {
  const Parameter p = q.parameters[i];
  const std::string what = fmt::format("{}: its interval is {:.0f} % as wide as the prior's", impact::name(p),
                                       100.0 * q.prior_shares[i]);
  if (p == Parameter::dwell_s)
    return what +
           ". No dwell time was measured, and lift-off depends on it only by the depth, through the "
           "footprint";
  if (p == Parameter::offset_reference_mps) return what + ". It takes spins well above and below it to tell";
  return what;
}

/// Sd of the logarithm of the value, by the slope at the mode.
double relative_sd(const impact::ModelFit& fit, std::size_t i) {
  const Parameter p = fit.posterior->parameters[i];
  const double value = fit.parameters[impact::index(p)].value;
  const double at = impact::coordinate_of(impact::ReboundModel::ode, p, value);
  return fit.posterior->coordinate_sds[i] * impact::slope_at(impact::ReboundModel::ode, p, at) / value;
}

/// The power product that the two tell best, with the relative sd: of the logarithms the least uncertain combination.
std::string about_pair(const impact::ModelFit& fit, std::size_t i, std::size_t j, double correlation) {
  const double sa = relative_sd(fit, i), sb = relative_sd(fit, j);
  const double power = -correlation * sa / sb;
  const double sd = sa * std::sqrt(1.0 - correlation * correlation);
  return fmt::format(
      "{0} and {1} apart: their correlation is {2:+.2f}. {0} · {1}^{3:.2f} is known to {4:.1f} %, {0} alone "
      "to {5:.1f} %",
      impact::name(fit.posterior->parameters[i]), impact::name(fit.posterior->parameters[j]), correlation,
      power, 100.0 * sd, 100.0 * sa);
}

}  // namespace

std::vector<std::string> untold(const impact::ModelFit& fit) {
  std::vector<std::string> out;
  if (!fit.posterior) return out;
  const impact::Posterior& q = *fit.posterior;
  for (std::size_t i = 0; i < q.parameters.size(); ++i)
    if (q.prior_shares[i] > impact::kUntoldShare) out.push_back(about_prior(q, i));
  for (std::size_t i = 0; i < q.parameters.size(); ++i) {
    for (std::size_t j = i + 1; j < q.parameters.size(); ++j) {
      const double rho = q.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (std::abs(rho) >= impact::kTiedCorrelation) out.push_back(about_pair(fit, i, j, rho));
    }
  }
  return out;
}

}  // namespace strobe::host
