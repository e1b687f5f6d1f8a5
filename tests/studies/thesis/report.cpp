#include "tests/studies/thesis/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace strobe::studies {

namespace {

using reduction::Quantity;

struct Column {
  Quantity quantity;
  const char* title;
  int decimals;
};
constexpr std::array kColumns{Column{Quantity::vx_lo_mps, "vx_LO", 2},
                              Column{Quantity::vy_lo_mps, "vy_LO", 2},
                              Column{Quantity::v_lo_mps, "v_LO", 2},
                              Column{Quantity::theta_out_deg, "angle_LO", 1},
                              Column{Quantity::omega_lo_radps, "omega_LO", 1},
                              Column{Quantity::e, "e", 3},
                              Column{Quantity::mu, "mu", 3},
                              Column{Quantity::dwell_time_ms, "dwell ms", 2},
                              Column{Quantity::dwell_distance_cm, "dwell cm", 2}};

bool is_tangential(const Cell& cell) {
  return cell.quantity == Quantity::vx_lo_mps || cell.quantity == Quantity::omega_lo_radps;
}

std::string figures(const Tally& t) {
  return fmt::format(" {:>5} {:>6.3f} {:>7.1f} {:>6}", t.count, t.rms_z, 100.0 * t.share_within_2,
                     t.beyond_3);
}

/// Root mean square of the sets' sd: what a spread is worth that 8 to 12 shots gave.
double pooled_sd(std::span<const Cell> cells, Quantity quantity) {
  double squares = 0.0, n = 0.0;
  for (const Cell& cell : cells) {
    if (cell.quantity != quantity) continue;
    squares += cell.published_sd * cell.published_sd;
    n += 1.0;
  }
  return std::sqrt(squares / n);
}

const PredictedCondition& predicted_condition(const Predictions& predictions, const std::string& condition) {
  return *std::ranges::find(predictions.conditions, condition,
                            [](const PredictedCondition& t) { return t.condition->name(); });
}

}  // namespace

std::string constants_table(const Predictions& f) {
  std::string text = fmt::format("{:<14} {:>6} {:>7} {:>7} {:>7} {:>6} {:>7} {:>6}   {}\n", "fitted without",
                                 "mu", "k_t/k", "c_t", "offset", "alpha", "w0 m/s", "chi2",
                                 "e and dwell time of the kept spins' regressions");
  for (const Constants& c : f.constants) {
    text += fmt::format("{:<14} {:>6.3f} {:>7.3f} {:>7.3f} {:>7.3f} {:>6.3f} {:>7.1f} {:>6.1f}", c.left_out,
                        c.value[impact::kFitMu], c.value[impact::kFitStiffness], c.value[impact::kFitDamping],
                        c.value[impact::kFitOffset], c.value[impact::kFitAlpha], c.offset_reference_mps,
                        c.chi_square);
    text += f.vertical == Vertical::measured
                ? "   not used: measured\n"
                : fmt::format("   e = {:.3f} {:+.4f} |vy| {:+.4f} s/|vy|, {:.2f} ms |vy|^{:.3f}\n", c.e_by[0],
                              c.e_by[1], c.e_by[2], 1e3 * std::exp(c.dwell_by[0]), c.dwell_by[1]);
  }
  return text;
}

std::string condition_table(std::span<const Cell> cells) {
  std::string text = fmt::format("{:<9}", "");
  for (const Column& column : kColumns) text += fmt::format(" {:>14}", column.title);
  text += "\n";
  for (auto cell = cells.begin(); cell != cells.end();) {
    const std::string& name = cell->condition;
    const auto end = std::find_if(cell, cells.end(), [&](const Cell& c) { return c.condition != name; });
    text += fmt::format("{:<9}", name);
    for (const Column& column : kColumns) {
      const auto found =
          std::find_if(cell, end, [&](const Cell& c) { return c.quantity == column.quantity; });
      text += found == end ? fmt::format(" {:>14}", "-")
                           : fmt::format(" {:>8.{}f} {:>5}", found->predicted, column.decimals,
                                         found->input ? "input" : fmt::format("{:+.1f}", found->z()));
    }
    text += "\n";
    cell = end;
  }
  return text;
}

std::string summary_header() {
  const std::string figures = fmt::format(" {:>5} {:>6} {:>7} {:>6}", "cells", "rms z", "% in 2", "over 3");
  return fmt::format("{:<52} {:^27} {:^27} {:^27}\n{:<52}{}{}{}\n", "", "vx, omega", "vx, vy, omega",
                     "all that is no input", "", figures, figures, figures);
}

std::string summary_line(const std::string& name, std::span<const Cell> cells) {
  return fmt::format("{:<52}{}{}{}\n", name, figures(tally(cells, is_tangential)),
                     figures(tally(cells, [](const Cell& c) { return is_lift_off_motion(c.quantity); })),
                     figures(tally(cells, [](const Cell& c) { return !c.input; })));
}

std::string beyond_3(const Predictions& predictions) {
  std::string text;
  for (const Cell& cell : predictions.cells) {
    if (cell.input || std::abs(cell.z()) <= 3.0) continue;
    const PredictedCondition& predicted = predicted_condition(predictions, cell.condition);
    const double pooled = pooled_sd(predictions.cells, cell.quantity);
    text +=
        fmt::format("{} {}: {:.4g} for {:.4g} ± {:.3g}, z {:+.1f}; by the sets' common sd of {:.3g} {:+.1f}",
                    cell.condition, name(cell.quantity), cell.predicted, cell.published, cell.published_sd,
                    cell.z(), pooled, cell.z() * cell.published_sd / pooled);
    if (is_tangential(cell)) {
      const bool vx = cell.quantity == Quantity::vx_lo_mps;
      const double spread = vx ? predicted.spread.vx_mps : predicted.spread.omega_radps;
      text += fmt::format("; with the published sd of what went in ({:.3g}) {:+.1f}", spread,
                          cell.z() * cell.published_sd / std::hypot(cell.published_sd, spread));
    }
    text += fmt::format(".\n   {}\n", reason(cell));
  }
  return text.empty() ? "none\n" : text;
}

std::string json_lines(const std::string& name, std::span<const Cell> cells) {
  std::string text;
  for (const Cell& cell : cells) {
    text += nlohmann::json{{"way", name},
                           {"condition", cell.condition},
                           {"quantity", std::string(reduction::name(cell.quantity))},
                           {"predicted", cell.predicted},
                           {"published", cell.published},
                           {"published_sd", cell.published_sd},
                           {"input", cell.input},
                           {"z", cell.z()}}
                .dump() +
            "\n";
  }
  return text;
}

std::string csv_header() { return "way,condition,quantity,predicted,published,published_sd,input,z\n"; }

std::string csv_lines(const std::string& name, std::span<const Cell> cells) {
  std::string text;
  for (const Cell& cell : cells)
    text += fmt::format("\"{}\",{},{},{},{},{},{},{}\n", name, cell.condition, reduction::name(cell.quantity),
                        cell.predicted, cell.published, cell.published_sd, cell.input ? 1 : 0, cell.z());
  return text;
}

std::string plot_program(std::span<const Cell> cells, const std::string& title, const std::string& file) {
  std::vector<std::string> names;
  for (const Cell& cell : cells)
    if (names.empty() || names.back() != cell.condition) names.push_back(cell.condition);
  std::string text = file.ends_with(".png")
                         ? "set terminal pngcairo size 1100,520 font 'sans,11'\n"
                         : "set terminal svg size 1100,520 font 'sans,12' background '#ffffff'\n";
  text += fmt::format("set output '{}'\nset title '{}'\n", file, title);
  text += fmt::format(
      "set ylabel '(predicted - published mean) / published sd'\nset xrange [-0.7:{}.7]\nset yrange [-6:6]\n"
      "set grid ytics lc rgb '#dddddd'\nset key top left horizontal\nset ytics 1\n"
      "set object 1 rectangle from graph 0,first -2 to graph 1,first 2 fc rgb '#eef4ea' fs solid noborder "
      "behind\n",
      names.size() - 1);
  text += "set xtics rotate by 45 right noenhanced (";
  for (std::size_t i = 0; i < names.size(); ++i)
    text += fmt::format("{}'{}' {}", i == 0 ? "" : ", ", names[i], i);
  text += ")\n";
  struct Series {
    Quantity quantity;
    const char* title;
    const char* style;
    double aside;
  };
  constexpr std::array kSeries{
      Series{Quantity::vx_lo_mps, "vx", "pt 7 ps 1.1 lc rgb '#1f5fa8'", -0.15},
      Series{Quantity::vy_lo_mps, "vy", "pt 9 ps 1.1 lc rgb '#8a8a8a'", 0.0},
      Series{Quantity::omega_lo_radps, "omega", "pt 5 ps 1.0 lc rgb '#c8501e'", 0.15}};
  std::string plots;
  for (const Series& series : kSeries) {
    std::string points;
    for (const Cell& cell : cells) {
      if (cell.quantity != series.quantity || cell.input) continue;
      const auto at = std::ranges::find(names, cell.condition) - names.begin();
      points += fmt::format("{} {}\n", static_cast<double>(at) + series.aside, cell.z());
    }
    if (points.empty()) continue;
    text += fmt::format("${} << END\n{}END\n", series.title, points);
    plots += fmt::format("{}${} using 1:2 with points {} title '{} at lift-off'",
                         plots.empty() ? "plot 0 lc rgb '#555555' notitle, " : ", ", series.title,
                         series.style, series.title);
  }
  return text + plots + "\n";
}

}  // namespace strobe::studies
