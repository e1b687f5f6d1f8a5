// The report of `strobe fit` for reading.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/impact/fit/rebound_model.hpp"
#include "host/commands/fit_report.hpp"

namespace strobe::host {

namespace {

using impact::FittedParameter;
using impact::kParameterCount;
using impact::Parameter;
using impact::ParameterStatus;

void write_out(const std::string& text) { std::fputs(text.c_str(), stdout); }

/// With as many digits as the sd bears: two of the sd's.
std::string with_sd(double value, double sd) {
  if (!(sd > 0.0)) return fmt::format("{:.6g} +- {:g}", value, sd);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(sd))), 0, 12);
  return fmt::format("{:.{}f} +- {:.{}f}", value, decimals, sd, decimals);
}

std::string percent(double level) { return fmt::format("{:.0f} %", 100.0 * level); }

/// The interval's ends with the sd's digits and one more; an end that is not there is the parameter's bound.
std::string interval_text(Parameter p, const FittedParameter& f) {
  if (!f.lower && !f.upper) return "; " + percent(impact::kIntervalLevel) + ": any value";
  const double sd = to_display_unit(p, *f.sd);
  const int decimals = sd > 0.0 ? std::clamp(2 - static_cast<int>(std::floor(std::log10(sd))), 0, 12) : 6;
  const auto end = [&](double value) { return fmt::format("{:.{}f}", to_display_unit(p, value), decimals); };
  const std::string level = "; " + percent(impact::kIntervalLevel) + ": ";
  if (!f.lower) return level + "at most " + end(*f.upper);
  if (!f.upper) return level + "at least " + end(*f.lower);
  return level + end(*f.lower) + " to " + end(*f.upper);
}

std::string limit_text(Parameter p, const FittedParameter& f) {
  if (!f.limit) return {};
  const bool upper = f.status == ParameterStatus::at_lower_bound;
  const std::string limit = fmt::format("; {} {:.4g} ({} one-sided)", upper ? "at most" : "at least",
                                        to_display_unit(p, *f.limit), percent(impact::kLimitLevel));
  if (f.status != ParameterStatus::undetermined) return limit;
  return limit + (p == Parameter::mu ? ": no shot is known to slide" : ": no shot is known to grip");
}

std::string value_text(Parameter p, const FittedParameter& f) {
  const double value = to_display_unit(p, f.value);
  if (f.sd) return with_sd(value, to_display_unit(p, *f.sd)) + display_unit(p) + interval_text(p, f);
  return fmt::format("{:.5g}{}  {}{}", value, display_unit(p), impact::name(f.status), limit_text(p, f));
}

bool each_has_its_dwell_time(const FitData& data) {
  return std::ranges::all_of(data.observations, [](const impact::Observation& o) { return o.dwell_s > 0.0; });
}

void print_parameters(const FitReport& r) {
  write_out(
      fmt::format("model {}: {} observations", impact::name(r.options.model), r.data.observations.size()));
  if (r.data.rejected + r.data.incomplete > 0)
    write_out(fmt::format(" ({} rejected and {} incomplete left out)", r.data.rejected, r.data.incomplete));
  write_out("\n");
  for (const std::string& shot : r.data.impossible) write_out("  left out: " + shot + "\n");
  for (const std::string& shot : r.data.repeated) write_out("  " + shot + "\n");
  for (std::size_t i = 0; i < kParameterCount; ++i) {
    const auto p = static_cast<Parameter>(i);
    if (!impact::has_parameter(r.options.model, p)) continue;
    const bool own_dwell = p == Parameter::dwell_s && each_has_its_dwell_time(r.data);
    write_out(fmt::format("  {:<{}} {}\n", impact::name(p), r.fit.posterior ? 15 : 6,
                          own_dwell ? "each observation's own" : value_text(p, r.fit.parameters[i])));
  }
}

void print_correlations(const impact::ModelFit& fit) {
  std::string line;
  for (std::size_t i = 0; i < kParameterCount; ++i) {
    for (std::size_t j = i + 1; j < kParameterCount; ++j) {
      const auto a = static_cast<Parameter>(i);
      const auto b = static_cast<Parameter>(j);
      if (!fit.parameters[i].sd || !fit.parameters[j].sd) continue;
      line += fmt::format("  {},{} {:+.2f}", impact::name(a), impact::name(b), fit.correlation(a, b));
    }
  }
  if (!line.empty()) write_out("correlations:" + line + "\n");
}

std::string check_text(const impact::Posterior& q) {
  const std::string draws = fmt::format("{} draws worth {:.0f}", q.sample.points.cols(), q.effective_size);
  switch (q.method) {
    case impact::PosteriorMethod::importance:
      return fmt::format("importance sampling from the Laplace approximation, {} (seed {}), Pareto k {:.2f}",
                         draws, q.seed, q.pareto_shape.value_or(0.0));
    case impact::PosteriorMethod::metropolis:
      return fmt::format("adaptive Metropolis, {} (seed {}), R-hat {:.3f}, {:.0f} % accepted", draws, q.seed,
                         q.r_hat.value_or(0.0), 100.0 * q.acceptance.value_or(0.0));
    default:
      return q.r_hat
                 ? fmt::format("the Laplace approximation, as no sampler moves: draws worth {:.0f} (seed {})",
                               q.effective_size, q.seed)
                 : "the Laplace approximation, not checked";
  }
}

/// 95 % of the prior, of those parameters that are fitted.
std::string priors_text(const impact::Posterior& q) {
  std::string out;
  for (const Parameter p : q.parameters) {
    const auto end = [&](double sds) { return to_display_unit(p, impact::prior_value(p, sds)); };
    out += fmt::format("{} {} {:.2g} to {:.2g}{}", out.empty() ? "" : ",", impact::name(p), end(-1.96),
                       end(1.96), display_unit(p));
  }
  return out;
}

void print_posterior(const FitReport& r) {
  if (!r.fit.posterior) return;
  const impact::Posterior& q = *r.fit.posterior;
  write_out("posterior: " + check_text(q));
  if (q.method != impact::PosteriorMethod::laplace)
    write_out(fmt::format("; ends of intervals within {:.1f} sd of Laplace's{}", q.laplace_shift,
                          q.reliable ? "" : "; too few draws for reliable intervals: more --draws"));
  write_out("\nprior, 95 %:" + priors_text(q) + "\n");
  for (const std::string& line : left_open(r.fit)) write_out("not determined: " + line + "\n");
}

std::string statistics_text(const impact::ResidualStatistics& a) {
  return fmt::format("rms {:.3f} m/s, {:.2f} rad/s; rms z {:.2f}, {:.2f}; within one sd {}, {} of {}",
                     a.rms_vx_mps, a.rms_omega_radps, a.rms_z_vx, a.rms_z_omega, a.within_sd_vx,
                     a.within_sd_omega, a.count);
}

std::string spread_text(const FitReport& r) {
  if (r.fit.covariance_scale != r.options.scale)
    return "from the stated sd: the observations scatter less than these let expect";
  if (r.options.scale == impact::CovarianceScale::stated) return "from the weights alone";
  if (r.options.scale == impact::CovarianceScale::residuals) return "scaled to the residuals (chi2/dof)";
  const bool by_shot = r.fit.clusters == static_cast<int>(r.data.observations.size());
  return fmt::format("from the residuals, {} {} being independent (cluster-robust, CR2)", r.fit.clusters,
                     by_shot ? "observations" : "conditions");
}

void print_quality(const FitReport& r) {
  const bool by_sd = r.options.weighting == impact::Weighting::stated_sd;
  write_out(fmt::format("chi2 {:.4g} for {} degrees of freedom, weights {}; sd and interval {}\n", r.fit.chi2,
                        r.fit.dof, by_sd ? "by the stated sd" : "1 per (m/s)^2 of vx and of R omega",
                        spread_text(r)));
  write_out("vx, omega at lift-off: " + statistics_text(r.fit.statistics) + "\n");
  if (!converged(r.fit.termination))
    write_out("the search stopped at its limit of steps: the minimum may not be reached\n");
}

std::string z_text(const std::optional<double>& z) { return z ? fmt::format("{:+.1f}", *z) : "-"; }
std::string probability_text(const std::optional<double>& p) { return p ? fmt::format("{:.3f}", *p) : "-"; }

void print_observations(const FitReport& r) {
  std::size_t width = 10;
  for (const impact::Observation& o : r.data.observations) width = std::max(width, o.name.size());
  write_out(
      fmt::format("\n{:<{}}   vx m/s  model     z   omega  model     z  regime   P(slides)  measured"
                  "   slip m/s     d mm (+- alpha)\n",
                  "", width));
  for (std::size_t i = 0; i < r.data.observations.size(); ++i) {
    const impact::Observation& o = r.data.observations[i];
    const impact::Comparison& c = r.fit.comparisons[i];
    const impact::RegimeClassification& g = r.regimes[i];
    const impact::RollingFriction& f = r.rolling_friction[i];
    write_out(
        fmt::format("{:<{}}  {:7.2f} {:6.2f} {:>5}  {:6.1f} {:6.1f} {:>5}  {:<7}  {:>9}  {:<8} "
                    "{:5.2f} +- {:4.2f} {:5.1f} +- {:3.1f} ({:3.1f})\n",
                    o.name, width, o.lift_off.vx_mps, c.predicted.lift_off.vx_mps, z_text(c.z_vx),
                    o.lift_off.omega_radps, c.predicted.lift_off.omega_radps, z_text(c.z_omega),
                    name(g.regime), probability_text(g.probability_slides), name(g.measured), g.slip_lo_mps,
                    g.slip_lo_sd_mps, 1e3 * f.offset_m, 1e3 * f.offset_sd_m, 1e3 * f.offset_sd_alpha_m));
  }
}

void print_rolling_friction(const FitReport& r) {
  const double alpha = r.fit.parameters[impact::index(Parameter::alpha)].value;
  const auto s = impact::summarize(r.rolling_friction);
  const std::string scatter =
      s.count > 1 ? fmt::format(", {:.2f} between observations", 1e3 * s.scatter_m) : "";
  write_out(fmt::format(
      "\nrolling friction from angular momentum (alpha {:.3g}): d {:.2f} mm{}, positive in {} of {}; "
      "systematic {:.2f} mm from alpha +- {:g}\n",
      alpha, 1e3 * s.mean_m, scatter, s.positive, s.count, 1e3 * s.mean_sd_alpha_m, ball::kAlphaSd));
}

void print_validation(const FitReport& r) {
  if (!r.validation) return;
  write_out(fmt::format("\nleft out in turn, by {}:\n",
                        r.grouped_by == impact::CrossValidationGroup::spin ? "spin" : "condition"));
  for (const impact::HeldOutGroup& group : r.validation->groups) {
    std::string values;
    for (std::size_t i = 0; i < kParameterCount; ++i) {
      const auto p = static_cast<Parameter>(i);
      if (r.options.free[i])
        values += fmt::format(" {} {:.4g}{}", impact::name(p),
                              to_display_unit(p, group.fit.parameters[i].value), display_unit(p));
    }
    write_out(fmt::format("  {:<10} {}  with{}\n", group.group, statistics_text(group.statistics), values));
  }
  write_out("  all        " + statistics_text(r.validation->statistics) + "\n");
}

}  // namespace

void print_fit_text(const FitReport& r) {
  print_parameters(r);
  print_correlations(r.fit);
  print_posterior(r);
  print_quality(r);
  print_observations(r);
  print_rolling_friction(r);
  print_validation(r);
}

// What the data of a fit do not tell, in words.

namespace {

/// A parameter of which the interval is little narrower than what was known before, or is so by the others'
/// alone.
std::string about_prior(const impact::Posterior& q, std::size_t i) {
  const Parameter p = q.parameters[i];
  if (q.prior_shares[i] <= impact::kUntoldShare)
    return fmt::format(
        "{}: the observations tell fewer combinations than there are coefficients, and others better",
        impact::name(p));
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

/// The power product that the two tell best, with the relative sd: of the logarithms the least uncertain
/// combination.
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

std::vector<std::string> left_open(const impact::ModelFit& fit) {
  std::vector<std::string> out;
  if (!fit.posterior) return out;
  const impact::Posterior& q = *fit.posterior;
  for (std::size_t i = 0; i < q.parameters.size(); ++i)
    if (fit.parameters[impact::index(q.parameters[i])].status == ParameterStatus::undetermined)
      out.push_back(about_prior(q, i));
  for (std::size_t i = 0; i < q.parameters.size(); ++i) {
    for (std::size_t j = i + 1; j < q.parameters.size(); ++j) {
      const double rho = q.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (std::abs(rho) >= impact::kTiedCorrelation) out.push_back(about_pair(fit, i, j, rho));
    }
  }
  return out;
}

}  // namespace strobe::host
