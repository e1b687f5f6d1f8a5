// The session's own data: run charts, and what goes with what.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/report/sections.hpp"
#include "host/view/series_view.hpp"

namespace strobe::report {

namespace {

using figures::Figure;
using figures::Panel;
using figures::PlotPoint;
using figures::Series;
using figures::Stroke;
using figures::Symbol;
using reduction::Quantity;
namespace colours = figures::colours;

constexpr Quantity kRunCharts[] = {Quantity::v_td_mps,
                                   Quantity::theta_in_deg,
                                   Quantity::omega_td_radps,
                                   Quantity::v_lo_mps,
                                   Quantity::theta_out_deg,
                                   Quantity::omega_lo_radps,
                                   Quantity::e,
                                   Quantity::mu,
                                   Quantity::dwell_time_ms};

const char* colour_of(const std::string& spin) {
  if (spin == "top") return colours::kTop;
  return spin == "back" ? colours::kBack : colours::kZero;
}

Symbol symbol_of(const std::string& spin) {
  if (spin == "top") return Symbol::triangle;
  return spin == "back" ? Symbol::square : Symbol::circle;
}

Series level(const char* what, double y, double to, Stroke stroke, const char* colour, bool legend) {
  return {.name = what,
          .legend = legend ? what : "",
          .stroke = stroke,
          .colour = colour,
          .points = {{0.5, y}, {to, y}}};
}

/// What of the shot's uncertainty others do not share; kNoValue without its budget.
double own_sd(const ReportShot& shot, Quantity q) {
  double variance = 0.0;
  for (const reduction::BudgetSource& source : shot.in_series->budget.sources)
    if (!reduction::is_shared(source.source)) variance += source.of(q) * source.of(q);
  return shot.in_series->budget.sources.empty() ? figures::kNoValue : std::sqrt(variance);
}

/// Every shot that has the number, in order of firing; those that do not count are open marks.
Panel run_panel(const Content& content, const ConditionGroup& group, Quantity q, bool legend) {
  Panel panel{.x_label = "shot", .y_label = axis_name(q)};
  Series counted{.name = "shots",
                 .legend = legend ? "shot ± sd of its own noise" : "",
                 .stroke = Stroke::points,
                 .colour = colour_of(group.spin),
                 .symbol = symbol_of(group.spin)};
  Series others{.name = "shots that do not count",
                .legend = "",
                .stroke = Stroke::points,
                .colour = "#999999",
                .symbol = open_symbol(symbol_of(group.spin))};
  for (std::size_t i = 0; i < group.shots.size(); ++i) {
    const auto& readout = group.shots[i].shot->readout;
    if (!readout.value[q]) continue;
    const double y = *readout.value[q], sd = own_sd(group.shots[i], q);
    (group.shots[i].counts ? counted : others)
        .points.push_back({static_cast<double>(i + 1), y, y - sd, y + sd});
  }
  if (legend && !others.points.empty()) others.legend = others.name;
  const host::QuantitySummary& s = group.of(q);
  const double to = static_cast<double>(group.shots.size()) + 0.5;
  if (s.n > 0) panel.series.push_back(level("mean", s.mean, to, Stroke::solid, "#666666", legend));
  if (s.n > 2 && s.scatter_sd)
    for (const double sign : {-1.0, 1.0})
      panel.series.push_back(level("mean ± 3 scatter sd", s.mean + sign * 3.0 * *s.scatter_sd, to,
                                   Stroke::dashed, "#666666", legend && sign > 0.0));
  for (const Limit& limit : content.input.limits) {
    if (limit.quantity != q) continue;
    for (const double y : {limit.low, limit.high})
      if (std::isfinite(y))
        panel.series.push_back(level("limit asked for", y, to, Stroke::dotted, "#c00000", false));
  }
  panel.series.push_back(std::move(counted));
  if (!others.points.empty()) panel.series.push_back(std::move(others));
  return panel;
}

Chart run_chart(const Content& content, const ConditionGroup& group) {
  Figure figure{.number = 0,
                .title = "Run charts: " + group.label,
                .caption =
                    "shots in the order of firing; bars: what of a shot's uncertainty the others do not "
                    "share; dotted, red: limits that were asked for",
                .columns = 3};
  std::vector<std::string> names;
  for (const ReportShot& each : group.shots) names.push_back(each.shot->name);
  for (const Quantity q : kRunCharts)
    figure.panels.push_back(run_panel(content, group, q, figure.panels.empty()));
  return make_chart("run_" + group.key, std::move(figure), names);
}

/// Shots that count, by condition; besides, the thesis's means of the same conditions.
Panel scatter_panel(const Content& content, Quantity x, Quantity y, bool legend) {
  Panel panel{.x_label = axis_name(x), .y_label = axis_name(y)};
  for (const char* spin : {"zero", "top", "back", ""}) {
    const std::string words = *spin ? std::string(thesis::spin_phrase(spin)) : "other";
    Series own{.name = words,
               .legend = {},
               .stroke = Stroke::points,
               .colour = *spin ? colour_of(spin) : colours::kMeasured,
               .symbol = symbol_of(spin)};
    for (const ConditionGroup& group : content.conditions) {
      if (is_known_spin(group.spin) ? group.spin != spin : *spin != '\0') continue;
      for (const ReportShot& each : group.counted) {
        const auto& value = each.shot->readout.value;
        if (value[x] && value[y]) own.points.push_back({*value[x], *value[y]});
      }
    }
    if (own.points.empty()) continue;
    if (legend) own.legend = words;
    panel.series.push_back(std::move(own));
  }
  return panel;
}

Chart scatter_chart(const Content& content, const char* key, std::string title,
                    const std::vector<std::pair<Quantity, Quantity>>& pairs) {
  Figure figure{
      .number = 0,
      .title = std::move(title),
      .caption = std::string("one point a shot that counts") +
                 (content.input.thesis ? "; grey: the thesis's means of the same conditions ± sd" : ""),
      .columns = static_cast<int>(pairs.size()),
      .legend_columns = 4};
  for (const auto& [x, y] : pairs) {
    const bool legend = figure.panels.empty();
    Panel panel = scatter_panel(content, x, y, legend);
    Series beside{.name = "thesis",
                  .legend = "",
                  .stroke = Stroke::points,
                  .colour = "#999999",
                  .symbol = Symbol::open_circle};
    for (const ConditionGroup& group : content.conditions) {
      if (!group.thesis) continue;
      const auto at = host::thesis_number(*group.thesis, x), of = host::thesis_number(*group.thesis, y);
      if (at && of) beside.points.push_back({at->mean, of->mean, of->mean - of->sd, of->mean + of->sd});
    }
    if (legend && !beside.points.empty()) beside.legend = "thesis";
    if (!beside.points.empty()) panel.series.insert(panel.series.begin(), std::move(beside));
    figure.panels.push_back(std::move(panel));
  }
  return make_chart(key, std::move(figure));
}

}  // namespace

Section figures(const Content& content) {
  Section section{"figures", "Figures"};
  if (std::ranges::none_of(content.shots, &ReportShot::counts)) {
    section.blocks.emplace_back(Paragraph{"none", "No shot counts: there is nothing to draw."});
    return section;
  }
  section.blocks.emplace_back(scatter_chart(content, "out_in", "Rebounding against incoming ball",
                                            {{Quantity::v_td_mps, Quantity::v_lo_mps},
                                             {Quantity::theta_in_deg, Quantity::theta_out_deg},
                                             {Quantity::omega_td_radps, Quantity::omega_lo_radps}}));
  section.blocks.emplace_back(scatter_chart(content, "e_mu", "Restitution and impulse ratio",
                                            {{Quantity::theta_in_deg, Quantity::e},
                                             {Quantity::theta_in_deg, Quantity::mu},
                                             {Quantity::mu, Quantity::e}}));
  for (const ConditionGroup& group : content.conditions)
    section.blocks.emplace_back(run_chart(content, group));
  return section;
}

}  // namespace strobe::report
