// What each shot says of things whose truth is known or constant, on control charts.
#include <fmt/format.h>

#include <cmath>

#include "host/report/sections.hpp"
#include "host/series/drift.hpp"
#include "host/view/drift_view.hpp"

namespace strobe::report {

namespace {

using figures::Figure;
using figures::Panel;
using figures::Series;
using figures::Stroke;
using host::ChartPoint;
using host::ControlChart;
using host::Witness;
namespace colours = figures::colours;

Series line_at(const char* what, double y, double to, bool legend) {
  return {.name = what,
          .legend = legend ? what : "",
          .stroke = Stroke::dashed,
          .colour = "#666666",
          .points = {{0.5, y}, {to, y}}};
}

/// Values with the mean and three standard deviations of single shots.
Panel individuals_panel(const ControlChart& chart, Witness w, double to, bool legend) {
  Panel panel{.x_label = "shot", .y_label = std::string(words(w))};
  Series shots{.name = std::string(name(w)),
               .legend = legend ? "shot ± sd" : "",
               .stroke = Stroke::points,
               .colour = colours::kZero};
  std::vector<double> values;
  for (const ChartPoint& p : chart.points()) {
    const auto& [value, sd] = p.measured;
    shots.points.push_back({static_cast<double>(p.shot + 1), value, value - sd, value + sd});
    values.push_back(value);
  }
  if (const auto limits = host::individuals_limits(values)) {
    panel.series.push_back(line_at("mean ± 3 sd", limits->lower, to, legend));
    panel.series.push_back(line_at("mean ± 3 sd", limits->upper, to, false));
  }
  panel.series.push_back(std::move(shots));
  return panel;
}

Panel cusum_panel(const ControlChart& chart, double to, bool legend) {
  Panel panel{.x_label = "shot", .y_label = "CUSUM"};
  Series upper{.name = "upper", .legend = legend ? "upper CUSUM" : "", .colour = colours::kTop};
  Series lower{.name = "lower", .legend = legend ? "lower CUSUM, downwards" : "", .colour = colours::kBack};
  for (const ChartPoint& p : chart.points()) {
    upper.points.push_back({static_cast<double>(p.shot + 1), p.upper});
    lower.points.push_back({static_cast<double>(p.shot + 1), -p.lower});
  }
  panel.series.push_back(line_at("alarm", chart.limit(), to, legend));
  panel.series.push_back(line_at("alarm", -chart.limit(), to, false));
  panel.series.push_back(std::move(upper));
  panel.series.push_back(std::move(lower));
  panel.zero_line = true;
  return panel;
}

Chart control_charts(const host::WitnessCharts& charts, const ConditionGroup& group) {
  Figure figure{
      .title = "Witnesses: " + group.label,
      .caption = fmt::format(
          "single shots with their limits, and beside them the CUSUM of what is off in sds (allowance "
          "{:g}); all charts together alarm once in {:.0f} sound shots or more",
          host::kCusumAllowance, host::kShotsPerFalseAlarm),
      .columns = 4};
  const double to = static_cast<double>(charts.shots().size()) + 0.5;
  std::vector<std::pair<Witness, const ControlChart*>> shown;
  for (std::size_t i = 0; i < host::kWitnessCount; ++i)
    if (const ControlChart* chart = charts.chart(static_cast<Witness>(i)))
      shown.emplace_back(static_cast<Witness>(i), chart);
  // A chart's sums stand beside its shots.
  for (const auto& [w, chart] : shown) {
    const bool legend = figure.panels.empty();
    figure.panels.push_back(individuals_panel(*chart, w, to, legend));
    figure.panels.push_back(cusum_panel(*chart, to, legend));
  }
  return make_chart("witnesses_" + group.key, std::move(figure), charts.shots());
}

}  // namespace

Section witnesses(const Content& content) {
  Section section{"witnesses", "Witnesses"};
  for (const ConditionGroup& group : content.conditions) {
    host::WitnessCharts charts;
    for (const ReportShot& each : group.counted) charts.add(each.name, host::witnesses(*each.in_series));
    if (charts.shots().size() < 2) continue;
    std::string said;
    for (const std::string& line : host::render_drift(charts)) append(said, line, "; ");
    if (said.empty())
      said = group.label + ": no drift of scale, clock, inclination, lens or lamps is told by the shots.";
    section.blocks.emplace_back(Paragraph{"drift_" + group.key, said, charts.verdict().has_value(), true});
    section.blocks.emplace_back(control_charts(charts, group));
  }
  if (section.blocks.empty())
    section.blocks.emplace_back(Paragraph{"none", "Fewer than two shots count: no drift can be told."});
  return section;
}

}  // namespace strobe::report
