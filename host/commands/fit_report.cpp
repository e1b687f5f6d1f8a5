#include "host/commands/fit_report.hpp"

#include <fmt/format.h>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/impact/fit/rebound_model.hpp"
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
  out["converged"] = converged(r.fit.termination);
  out.update(statistics_json(r.fit.statistics));
  out["clusters"] = r.fit.clusters;
  if (r.fit.posterior) out["posterior"] = posterior_json(r.fit);
  out["inputs"] = {{"weights", by_sd ? "sd" : "equal"},  {"covariance", impact::name(r.fit.covariance_scale)},
                   {"diameter_m", r.options.diameter_m}, {"rejected", r.data.rejected},
                   {"incomplete", r.data.incomplete},    {"impossible", r.data.impossible},
                   {"repeated", r.data.repeated}};
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

}  // namespace strobe::host
