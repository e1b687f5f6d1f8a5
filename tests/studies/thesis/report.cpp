#include "tests/studies/thesis/report.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

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

std::string reason(const Cell& cell) {
  using reduction::Quantity;
  const std::string_view c = cell.condition;
  const bool contact =
      cell.quantity == Quantity::dwell_time_ms || cell.quantity == Quantity::dwell_distance_cm;
  if (c == "back_17")
    return "A set apart: it slides throughout, with mu .625 where the two others that do have .50 and .52,\n"
           "   and e is .77 where sets as slow have .88. Constants fitted to all sets leave vx 4.4 sd off.";
  if (c == "back_40")
    return "Its printed spreads are among the least of all sets (vx .10 m/s, less than digitizing by hand\n"
           "   leaves), and its spin is less than a line between its neighbours at 35 and 45 degrees gives.";
  if (c == "back_35")
    return "Its e, .711, is below those of the faster sets at 40 and 45 degrees (.733, .750), and its dwell\n"
           "   time of 5.02 ms that of a slower one: no function that falls with the speed passes all three.";
  if (c == "top_48" && contact)
    return "Its dwell time, 3.86 ms, is below those of slower and of faster sets (4.49 at 42 degrees, 4.05\n"
           "   at 61): no function that falls with the speed passes all three. The distance goes with it.";
  if (c == "top_23")
    return "The printed spread of .47 degree is half of what those of vx and vy give (.8): by the common\n"
           "   one it is no exception. Its e, .905, is the largest of all.";
  if (c == "zero_60" && (cell.quantity == Quantity::vy_lo_mps || cell.quantity == Quantity::e))
    return "Its e, .716, is above that of the slower set at 49 degrees (.707), and its spread of vy small.";
  if (cell.quantity == Quantity::dwell_distance_cm)
    return "Distances of steep shots come out short in most sets, by a tenth or so: not explained.";
  return "No reason found in the tables.";
}

}  // namespace strobe::studies
