#include "host/commands/fit_report.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/impact/fit/coefficient_prior.hpp"
#include "common/messages/or_null.hpp"
#include "common/messages/parsed_json.hpp"

namespace strobe::host {

namespace {

using impact::FittedParameter;
using impact::kParameterCount;
using impact::Parameter;
using impact::ParameterStatus;
using impact::ResidualStatistics;
using nlohmann::ordered_json;

constexpr double kTwoSided95 = 1.959963984540054;  ///< sds

bool shown_in_thousandths(Parameter p) { return p == Parameter::offset_m || p == Parameter::dwell_s; }

void print_line(const ordered_json& object) { std::printf("%s\n", messages::json_text(object).c_str()); }

ordered_json edge_number(Parameter p, const std::optional<double>& value) {
  return value ? ordered_json(to_display_unit(p, *value)) : ordered_json();
}

std::string key(Parameter p) {
  constexpr std::array<const char*, kParameterCount> keys{
      "mu", "ex", "d_mm", "u0_mps", "alpha", "stiffness_ratio", "damping_ratio", "offset_share", "dwell_ms"};
  return keys[impact::index(p)];
}

ordered_json parameters_json(const impact::ModelFit& fit, impact::ReboundModel model) {
  ordered_json out;
  for (std::size_t i = 0; i < kParameterCount; ++i) {
    const auto p = static_cast<Parameter>(i);
    if (!impact::has_parameter(model, p)) continue;
    const FittedParameter& f = fit.parameters[i];
    out[key(p)] = {{"value", to_display_unit(p, f.value)},
                   {"sd", edge_number(p, f.sd)},
                   {"interval_95", {edge_number(p, f.lower), edge_number(p, f.upper)}},
                   {"degrees_of_freedom", messages::or_null(f.degrees_of_freedom)},
                   {"limit", edge_number(p, f.limit)},
                   {"status", impact::name(f.status)}};
  }
  return out;
}

bool fitted(const impact::ModelFit& fit, std::size_t i) {
  return fit.parameters[i].status == ParameterStatus::fitted;
}

ordered_json correlations_json(const impact::ModelFit& fit) {
  ordered_json out = ordered_json::object();
  for (std::size_t i = 0; i < kParameterCount; ++i) {
    for (std::size_t j = i + 1; j < kParameterCount; ++j) {
      const auto a = static_cast<Parameter>(i);
      const auto b = static_cast<Parameter>(j);
      if (!fitted(fit, i) || !fitted(fit, j)) continue;
      out[fmt::format("{},{}", impact::name(a), impact::name(b))] = fit.correlation(a, b);
    }
  }
  return out;
}

ordered_json statistics_json(const ResidualStatistics& a) {
  return {{"count", a.count},
          {"rms_vx_mps", a.rms_vx_mps},
          {"rms_omega_radps", a.rms_omega_radps},
          {"rms_z_vx", a.rms_z_vx},
          {"rms_z_omega", a.rms_z_omega},
          {"within_sd_vx", a.within_sd_vx},
          {"within_sd_omega", a.within_sd_omega}};
}

ordered_json comparison_json(const impact::Observation& o, const impact::Comparison& c) {
  return {{"name", o.name},
          {"spin", o.spin},
          {"series", o.series},
          {"vx_lo_mps", o.lift_off.vx_mps},
          {"vx_lo_predicted_mps", c.predicted.lift_off.vx_mps},
          {"sd_vx_lo_mps", o.lift_off_sd.vx_mps},
          {"z_vx", messages::or_null(c.z_vx)},
          {"z_vx_with_inputs", messages::or_null(c.z_vx_with_inputs)},
          {"omega_lo_radps", o.lift_off.omega_radps},
          {"omega_lo_predicted_radps", c.predicted.lift_off.omega_radps},
          {"sd_omega_lo_radps", o.lift_off_sd.omega_radps},
          {"z_omega", messages::or_null(c.z_omega)},
          {"z_omega_with_inputs", messages::or_null(c.z_omega_with_inputs)}};
}

void add_regime(const impact::RegimeClassification& r, ordered_json& out) {
  out["regime"] = name(r.regime);
  out["regime_model"] = name(r.predicted);
  out["probability_slides"] = messages::or_null(r.probability_slides);
  out["friction_needed_mps"] = r.friction_needed_mps;
  out["friction_available_mps"] = messages::or_null(r.friction_available_mps);
  out["sd_friction_margin_mps"] = messages::or_null(r.margin_sd_mps);
  out["slip_lo_mps"] = r.slip_lo_mps;
  out["sd_slip_lo_mps"] = r.slip_lo_sd_mps;
  out["slip_lo_predicted_mps"] = r.slip_lo_predicted_mps;
  out["sd_slip_lo_predicted_mps"] = r.slip_lo_predicted_sd_mps;
  out["regime_measured"] = name(r.measured);
}

void add_rolling_friction(const impact::RollingFriction& r, ordered_json& out) {
  out["d_mm"] = 1e3 * r.offset_m;
  out["sd_d_mm"] = 1e3 * r.offset_sd_m;
  out["sd_systematic_d_mm"] = 1e3 * r.offset_sd_alpha_m;
  out["rolling_friction"] = r.coefficient;
  out["sd_rolling_friction"] = r.coefficient_sd;
}

ordered_json prior_json(Parameter p) {
  const auto value = [&](double sds) { return to_display_unit(p, impact::prior_value(p, sds)); };
  return {{"median", value(0.0)}, {"interval_95", {value(-kTwoSided95), value(kTwoSided95)}}};
}

ordered_json posterior_json(const impact::ModelFit& fit) {
  const impact::Posterior& q = *fit.posterior;
  ordered_json out{{"method", impact::name(q.method)},
                   {"seed", q.seed},
                   {"draws", q.sample.points.cols()},
                   {"effective_draws", q.effective_size},
                   {"pareto_k", messages::or_null(q.pareto_shape)},
                   {"r_hat", messages::or_null(q.r_hat)},
                   {"acceptance", messages::or_null(q.acceptance)},
                   {"reliable", q.reliable},
                   {"evaluations", q.evaluations},
                   {"largest_shift_from_laplace_sd", q.laplace_shift}};
  ordered_json names = ordered_json::array(), matrix = ordered_json::array(), priors, medians, shares;
  for (std::size_t i = 0; i < q.parameters.size(); ++i) {
    const Parameter p = q.parameters[i];
    names.push_back(key(p));
    priors[key(p)] = prior_json(p);
    medians[key(p)] = to_display_unit(p, q.medians[i]);
    shares[key(p)] = q.prior_shares[i];
    const Eigen::VectorXd row = q.correlation.row(static_cast<Eigen::Index>(i));
    matrix.push_back(std::vector<double>(row.begin(), row.end()));
  }
  out["prior"] = priors;
  out["median"] = medians;
  out["sd_over_prior_sd"] = shares;
  out["correlation_parameters"] = names;
  out["correlation"] = matrix;
  out["untold"] = left_open(fit);
  return out;
}

ordered_json fit_json(const FitReport& r) {
  const bool by_sd = r.options.weighting == impact::Weighting::stated_sd;
  ordered_json out{{"type", "fit"}, {"model", impact::name(r.options.model)}};
  out["parameters"] = parameters_json(r.fit, r.options.model);
  out["correlation"] = correlations_json(r.fit);
  out["chi2"] = r.fit.chi2;
  out["dof"] = r.fit.dof;
  out["variance_scale"] = r.fit.variance_scale;
  out["converged"] = r.fit.converged;
  out.update(statistics_json(r.fit.statistics));
  out["clusters"] = r.fit.clusters;
  if (r.fit.posterior) out["posterior"] = posterior_json(r.fit);
  out["inputs"] = {{"weights", by_sd ? "sd" : "equal"},  {"covariance", impact::name(r.options.scale)},
                   {"diameter_m", r.options.diameter_m}, {"rejected", r.data.rejected},
                   {"incomplete", r.data.incomplete},    {"impossible", r.data.impossible}};
  if (r.fit.posterior) out["inputs"]["gravity_mps2"] = r.data.observations.front().gravity_mps2;
  return out;
}

}  // namespace

double to_display_unit(Parameter p, double value) { return shown_in_thousandths(p) ? 1e3 * value : value; }
double from_display_unit(Parameter p, double value) { return shown_in_thousandths(p) ? value / 1e3 : value; }

const char* display_unit(Parameter p) {
  if (p == Parameter::offset_m) return " mm";
  if (p == Parameter::dwell_s) return " ms";
  return p == Parameter::offset_reference_mps ? " m/s" : "";
}

void print_fit_json(const FitReport& r) {
  print_line(fit_json(r));
  for (std::size_t i = 0; i < r.data.observations.size(); ++i) {
    ordered_json out{{"type", "observation"}};
    out.update(comparison_json(r.data.observations[i], r.fit.comparisons[i]));
    add_regime(r.regimes[i], out);
    add_rolling_friction(r.rolling_friction[i], out);
    print_line(out);
  }
  if (!r.validation) return;
  for (const impact::HeldOutGroup& group : r.validation->groups) {
    ordered_json out{{"type", "left_out"}, {"group", group.group}};
    out["parameters"] = parameters_json(group.fit, r.options.model);
    out.update(statistics_json(group.statistics));
    print_line(out);
  }
  ordered_json out{{"type", "validation"},
                   {"left_out", r.grouped_by == impact::CrossValidationGroup::spin ? "spin" : "condition"}};
  out.update(statistics_json(r.validation->statistics));
  print_line(out);
}

// The report of `strobe fit` for reading.

namespace {

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
      return "the Laplace approximation, not checked";
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
  for (const std::string& line : left_open(r.fit)) write_out("not told: " + line + "\n");
}

std::string statistics_text(const impact::ResidualStatistics& a) {
  return fmt::format("rms {:.3f} m/s, {:.2f} rad/s; rms z {:.2f}, {:.2f}; within one sd {}, {} of {}",
                     a.rms_vx_mps, a.rms_omega_radps, a.rms_z_vx, a.rms_z_omega, a.within_sd_vx,
                     a.within_sd_omega, a.count);
}

std::string spread_text(const FitReport& r) {
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
  if (!r.fit.converged)
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
  write_out(
      fmt::format("\nrolling friction from angular momentum (alpha {:.3g}): d {:.2f} mm, {:.2f} between "
                  "observations, positive in {} of {}; systematic {:.2f} mm from alpha +- {:g}\n",
                  alpha, 1e3 * s.mean_m, 1e3 * s.scatter_m, s.positive, s.count, 1e3 * s.mean_sd_alpha_m,
                  ball::kAlphaSd));
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

std::vector<std::string> left_open(const impact::ModelFit& fit) {
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
