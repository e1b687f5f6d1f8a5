#include "host/bounces/report.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "common/messages/parsed_json.hpp"

namespace strobe::bounces {

namespace {

using published::Measured;

/// Residuals over their sds.
std::string z_text(const Measured& residual) {
  return residual.sd > 0.0 ? fmt::format("{:+.1f}", residual.value / residual.sd) : "-";
}

std::string head() {
  std::string line = fmt::format("{:<27}{:>6}  {:>15}", "", "mu", "measured");
  for (const Model model : kModels) line += fmt::format("  {:>9}{:>6}", name(model), "z");
  return line + "\n";
}

/// Name and friction of a bounce, which its first line begins with.
std::string row_head(const Case& c, const char* quantity) {
  return fmt::format("{:<21}{:>6}{:>6.3f}{}", c.bounce.name, quantity, c.mu(),
                     c.tells_its_own_friction() ? "* " : "  ");
}

std::string vx_line(const Row& row) {
  const Measured& vx = *row.bounce.bounce.vx_lo_mps;
  std::string line = row_head(row.bounce, "vx") + fmt::format("{:>6.2f} ± {:<6.2f}", vx.value, vx.sd);
  for (const Prediction& p : row.predictions)
    line += fmt::format("  {:>9.2f}{:>6}", p.lift_off.vx_mps,
                        p.vx_is_given ? "given" : z_text(*p.residual.vx_mps));
  return line + "\n";
}

std::string omega_line(const Row& row, const std::string& begin) {
  const Measured& omega = *row.bounce.bounce.omega_lo_radps;
  std::string line = begin + fmt::format("{:>6.1f} ± {:<6.1f}", omega.value, omega.sd);
  for (const Prediction& p : row.predictions)
    line += fmt::format("  {:>9.1f}{:>6}", p.lift_off.omega_radps, z_text(*p.residual.omega_radps));
  return line + "\n";
}

std::string lines_of(const Row& row) {
  if (!row.bounce.bounce.vx_lo_mps) return omega_line(row, row_head(row.bounce, "omega"));
  if (!row.bounce.bounce.omega_lo_radps) return vx_line(row);
  return vx_line(row) + omega_line(row, fmt::format("{:>27}{:>8}", "omega", ""));
}

std::string agreement_lines(const std::vector<Row>& rows) {
  std::string vx = fmt::format("{:<21}{:>6}{:>23}", "rms; of z", "vx", "");
  std::string omega = fmt::format("{:>27}{:>23}", "omega", "");
  for (const Model model : kModels) {
    const Agreement a = agreement_of(rows, model);
    vx += a.vx_count > 0 ? fmt::format("  {:>9.2f}{:>6.1f}", a.vx_rms_mps, a.vx_z_rms)
                         : fmt::format("  {:>9}{:>6}", "-", "-");
    omega += a.omega_count > 0 ? fmt::format("  {:>9.1f}{:>6.1f}", a.omega_rms_radps, a.omega_z_rms)
                               : fmt::format("  {:>9}{:>6}", "-", "-");
  }
  return vx + "\n" + omega + "\n";
}

std::string balance_lines(const std::vector<Row>& rows) {
  std::string lines;
  for (const Row& row : rows) {
    if (!row.level || !row.with_weight) continue;
    const bool inclined = row.bounce.bounce.incline_deg.has_value();
    lines += fmt::format(
        "{:<27}{:>+6.2f}   {:>5.3f} ± {:.3f}   {:>13}   {:>+6.1f} ± {:.1f} ± {:.1f}\n",
        row.bounce.bounce.name, row.level->e_x, row.level->alpha.value, row.level->alpha.sd,
        inclined ? fmt::format("{:.3f} ± {:.3f}", row.with_weight->alpha.value, row.with_weight->alpha.sd)
                 : "-",
        row.with_weight->offset_m.value * 1e3, row.with_weight->offset_m.sd * 1e3,
        row.with_weight->offset_sd_alpha_m * 1e3);
  }
  if (lines.empty()) return {};
  return fmt::format("{:<27}{:>6}   {:>13}   {:>13}   {}\n", "angular momentum", "ex", "alpha", "with weight",
                     "offset mm ± statistical ± by alpha") +
         lines;
}

/// One alpha for the set's rows, as if level and with the weight, if there are several on known inclines.
std::string mean_alpha_line(const std::vector<Row>& rows) {
  std::vector<Measured> level, with_weight;
  for (const Row& row : rows) {
    if (!row.level || !row.with_weight || !row.bounce.bounce.incline_deg) continue;
    level.push_back(row.level->alpha);
    with_weight.push_back(row.with_weight->alpha);
  }
  if (level.size() < 2) return {};
  const MeanAlpha before = mean_of(level), after = mean_of(with_weight);
  return fmt::format(
      "{:<27}{:>6}   {:>5.3f} ± {:.3f}   {:.3f} ± {:.3f}   chi-square {:.1f} and {:.1f} of {} degrees\n",
      "one alpha for all", "", before.alpha.value, before.alpha.sd, after.alpha.value, after.alpha.sd,
      before.chi_square, after.chi_square, before.count - 1);
}

nlohmann::ordered_json value_json(const std::optional<Measured>& number) {
  return number ? nlohmann::ordered_json(number->value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json sd_json(const std::optional<Measured>& number) {
  return number ? nlohmann::ordered_json(number->sd) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json measured_json(const published::Bounce& b) {
  return {{"vx_lo_mps", value_json(b.vx_lo_mps)},
          {"vx_lo_sd_mps", sd_json(b.vx_lo_mps)},
          {"omega_lo_radps", value_json(b.omega_lo_radps)},
          {"omega_lo_sd_radps", sd_json(b.omega_lo_radps)}};
}

nlohmann::ordered_json prediction_json(const Prediction& p) {
  return {{"vx_lo_mps", p.lift_off.vx_mps},
          {"vy_lo_mps", p.lift_off.vy_mps},
          {"omega_lo_radps", p.lift_off.omega_radps},
          {"mu", p.mu},
          {"vx_is_given", p.vx_is_given},
          {"vx_residual_mps", value_json(p.residual.vx_mps)},
          {"vx_residual_sd_mps", sd_json(p.residual.vx_mps)},
          {"omega_residual_radps", value_json(p.residual.omega_radps)},
          {"omega_residual_sd_radps", sd_json(p.residual.omega_radps)},
          {"not_valid", p.not_valid}};
}

nlohmann::ordered_json balance_json(const std::optional<Balance>& balance) {
  if (!balance) return nullptr;
  return {{"alpha", balance->alpha.value},
          {"alpha_sd", balance->alpha.sd},
          {"offset_mm", balance->offset_m.value * 1e3},
          {"offset_sd_mm", balance->offset_m.sd * 1e3},
          {"offset_sd_alpha_mm", balance->offset_sd_alpha_m * 1e3},
          {"slip_lo_mps", balance->slip_lo_mps},
          {"ex", balance->e_x}};
}

}  // namespace

Result<std::vector<Row>> rows_of(const published::Bounces& all, const published::Set& set) {
  std::vector<Row> rows;
  for (const Case& c : cases_of(all, set)) {
    Row row{
        .bounce = c, .predictions = {}, .level = balance_of(c, false), .with_weight = balance_of(c, true)};
    for (std::size_t i = 0; i < kModels.size(); ++i) {
      const auto predicted = predict(c, kModels[i]);
      if (!predicted) return fail(set.name + ": " + predicted.error().message);
      row.predictions[i] = *predicted;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

Agreement agreement_of(const std::vector<Row>& rows, Model model) {
  Agreement a;
  const auto add = [&a](const Measured& residual, int& count, double& square, double& z_square) {
    ++count;
    square += residual.value * residual.value;
    if (residual.sd > 0.0) z_square += std::pow(residual.value / residual.sd, 2);
    if (std::abs(residual.value) <= kCoverageSds * residual.sd) ++a.covered;
  };
  for (const Row& row : rows) {
    const Prediction& p = row.predictions[static_cast<std::size_t>(model)];
    const Residual& r = p.residual;
    if (r.vx_mps && !p.vx_is_given) add(*r.vx_mps, a.vx_count, a.vx_rms_mps, a.vx_z_rms);
    if (r.omega_radps) add(*r.omega_radps, a.omega_count, a.omega_rms_radps, a.omega_z_rms);
  }
  for (double* sum : {&a.vx_rms_mps, &a.vx_z_rms}) *sum = a.vx_count > 0 ? std::sqrt(*sum / a.vx_count) : 0.0;
  for (double* sum : {&a.omega_rms_radps, &a.omega_z_rms})
    *sum = a.omega_count > 0 ? std::sqrt(*sum / a.omega_count) : 0.0;
  return a;
}

std::string text(const published::Set& set, const std::vector<Row>& rows) {
  std::string out = set.name + "\n  " + set.publication + "\n" + head();
  for (const Row& row : rows) out += lines_of(row);
  return out + agreement_lines(rows) + balance_lines(rows) + mean_alpha_line(rows);
}

std::string summary_head() {
  return fmt::format("{:<21}{:<10}{:>8}{:>13}{:>12}{:>17}{:>7}  {}\n", "set", "model", "numbers",
                     "within 95 %", "rms vx m/s", "rms omega rad/s", "rms z", "valid");
}

namespace {

std::string summary_line(const std::string& name_of_set, const std::vector<Row>& rows, Model model) {
  std::vector<Row> valid;
  std::string_view reason;
  for (const Row& row : rows) {
    const std::string_view against = row.predictions[static_cast<std::size_t>(model)].not_valid;
    if (against.empty()) valid.push_back(row);
    if (reason.empty()) reason = against;
  }
  const Agreement a = agreement_of(valid.empty() ? rows : valid, model);
  const int count = a.vx_count + a.omega_count;
  const double z =
      std::sqrt((a.vx_count * a.vx_z_rms * a.vx_z_rms + a.omega_count * a.omega_z_rms * a.omega_z_rms) /
                std::max(count, 1));
  const auto rms = [](int of, double value, int digits) {
    return of > 0 ? fmt::format("{:.{}f}", value, digits) : std::string("-");
  };
  const std::string says = valid.empty() ? fmt::format("no: {}", reason)
                           : reason.empty()
                               ? "yes"
                               : fmt::format("{} of {} rows: {}", valid.size(), rows.size(), reason);
  return fmt::format("{:<21}{:<10}{:>8}{:>11.0f} %{:>12}{:>17}{:>7.1f}  {}\n", name_of_set, name(model),
                     count, 100.0 * a.covered / std::max(count, 1), rms(a.vx_count, a.vx_rms_mps, 3),
                     rms(a.omega_count, a.omega_rms_radps, 1), z, says);
}

}  // namespace

std::string summary(const published::Set& set, const std::vector<Row>& rows) {
  std::string out;
  for (const Model model : kModels) out += summary_line(out.empty() ? set.name : "", rows, model);
  return out;
}

std::string json(const published::Set& set, const Row& row) {
  using nlohmann::ordered_json;
  const Case& c = row.bounce;
  const auto& elsewhere = c.friction.elsewhere;
  ordered_json out{
      {"set", set.name},
      {"row", c.bounce.name},
      {"ball", c.ball.name},
      {"surface", c.bounce.surface},
      {"incline_deg", c.bounce.incline_deg ? ordered_json(*c.bounce.incline_deg) : ordered_json(nullptr)},
      {"mu", c.mu()},
      {"mu_from", c.friction.row.empty() ? ordered_json(nullptr) : ordered_json(c.friction.row)},
      {"mu_elsewhere", elsewhere ? ordered_json(elsewhere->value) : ordered_json(nullptr)},
      {"measured", measured_json(c.bounce)}};
  for (std::size_t i = 0; i < kModels.size(); ++i)
    out["predictions"][std::string(name(kModels[i]))] = prediction_json(row.predictions[i]);
  out["balance"] = balance_json(row.with_weight);
  out["balance_level"] = balance_json(row.level);
  return messages::json_text(out);
}

namespace {

constexpr std::array<const char*, kModels.size()> kColours{figures::colours::kConstrained,
                                                           figures::colours::kCubic, figures::colours::kZero,
                                                           figures::colours::kTop, figures::colours::kBack};
constexpr std::array kSymbols{figures::Symbol::open_square, figures::Symbol::open_triangle,
                              figures::Symbol::open_circle, figures::Symbol::circle,
                              figures::Symbol::triangle};

figures::Panel panel_of(const std::vector<Row>& rows, published::Build build, const char* title,
                        bool legend) {
  figures::Panel panel{
      .title = title, .x_label = "measured topspin, rad/s", .y_label = "predicted topspin, rad/s"};
  double most = 1.0;
  for (std::size_t i = 0; i < kModels.size(); ++i) {
    const std::string model(name(kModels[i]));
    figures::Series series{.name = std::string(title) + " " + model,
                           .legend = legend ? model : std::string(),
                           .stroke = figures::Stroke::points,
                           .colour = kColours[i],
                           .symbol = kSymbols[i]};
    for (const Row& row : rows) {
      if (row.bounce.ball.build != build || !row.bounce.bounce.omega_lo_radps) continue;
      if (build == published::Build::shell && kModels[i] == Model::elastic) continue;  // says nothing of it
      series.points.push_back(
          {.x = -row.bounce.bounce.omega_lo_radps->value, .y = -row.predictions[i].lift_off.omega_radps});
      most = std::max({most, series.points.back().x, series.points.back().y});
    }
    panel.series.push_back(std::move(series));
  }
  panel.series.insert(panel.series.begin(), {.name = std::string(title) + " equal",
                                             .legend = legend ? "predicted = measured" : "",
                                             .stroke = figures::Stroke::solid,
                                             .colour = "#888888",
                                             .points = {{0.0, 0.0}, {most, most}}});
  return panel;
}

}  // namespace

figures::Figure spin_figure(const std::vector<Row>& rows) {
  figures::Figure figure{.number = 1,
                         .title = "Spin after the bounces that others have published",
                         .caption = "Predicted before anything is fitted; models as in strobe bounces.",
                         .legend_columns = 3};
  const auto add_panel = [&](published::Build build, const char* title) {
    const auto of_build = [build](const Row& row) { return row.bounce.ball.build == build; };
    if (std::ranges::any_of(rows, of_build))
      figure.panels.push_back(panel_of(rows, build, title, figure.panels.empty()));
  };
  add_panel(published::Build::shell, "tennis ball");
  add_panel(published::Build::solid, "solid balls");
  figure.columns = static_cast<int>(figure.panels.size());
  return figure;
}

}  // namespace strobe::bounces
