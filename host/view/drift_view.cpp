#include "host/view/drift_view.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/text/text.hpp"

namespace strobe::host {
namespace {

using nlohmann::ordered_json;
using Lines = std::vector<std::string>;

constexpr std::array<std::string_view, kWitnessCount> kColumns{
    "g, m/s2", "balls, px/m", "surface, deg", "lamp A, us", "lamp B, us", "clock, ppm", "paths"};

std::string_view name_in_words(Culprit culprit) {
  constexpr std::array<std::string_view, kCulpritCount> kWords{"the camera's scale (zoom, focus, distance)",
                                                               "the ball's diameter",
                                                               "the rig's clock (or this computer's)",
                                                               "the inclination of camera or surface",
                                                               "lamp A or its sensor",
                                                               "lamp B or its sensor",
                                                               "the air",
                                                               "the lens"};
  return kWords[static_cast<std::size_t>(culprit)];
}

std::string cause_words(const std::vector<Culprit>& culprits) {
  if (culprits.empty()) return "  no single thing explains it";
  std::string all;
  for (const Culprit c : culprits) all += (all.empty() ? "" : ", or ") + std::string(name_in_words(c));
  return "  likely: " + all + (culprits.size() > 1 ? "; the shots cannot tell them apart" : "");
}

bool has_moved(const WitnessShift& shift) { return std::abs(shift.change.value) > 3.0 * shift.change.sd; }

std::string shift_words(const WitnessShift& shift) {
  return fmt::format("  {}: from {} by {} ± {}", words(shift.witness),
                     rounded(shift.before.value, shift.change.sd),
                     rounded(shift.change.value, shift.change.sd), rounded(shift.change.sd, shift.change.sd));
}

/// The chart's point of the shot; null: it had no such number.
const ChartPoint* point_of(const WitnessCharts& charts, std::size_t w, std::size_t shot) {
  const ControlChart* chart = charts.chart(static_cast<Witness>(w));
  if (!chart) return nullptr;
  const auto found = std::ranges::lower_bound(chart->points(), shot, {}, &ChartPoint::shot);
  return found != chart->points().end() && found->shot == shot ? &*found : nullptr;
}

ordered_json chart_json(const WitnessCharts& charts, const ControlChart& chart) {
  ordered_json points = ordered_json::array();
  for (const ChartPoint& p : chart.points()) {
    points.push_back({{"shot", charts.shot(p.shot)},
                      {"value", p.measured.value},
                      {"sd", p.measured.sd},
                      {"score", p.score},
                      {"upper", p.upper},
                      {"lower", p.lower}});
  }
  return {{"limit", chart.limit()}, {"points", points}};
}

ordered_json verdict_json(const DriftVerdict& verdict) {
  ordered_json object{{"alarms", ordered_json::array()}, {"shifts", ordered_json::array()}};
  for (const DriftAlarm& a : verdict.alarms)
    object["alarms"].push_back({{"chart", name(a.chart)}, {"shot", a.shot}, {"since", a.since}});
  for (const WitnessShift& s : verdict.shifts)
    object["shifts"].push_back({{"witness", name(s.witness)},
                                {"before", s.before.value},
                                {"before_sd", s.before.sd},
                                {"change", s.change.value},
                                {"change_sd", s.change.sd}});
  ordered_json& culprits = object["culprits"] = ordered_json::array();
  for (const Culprit c : verdict.culprits) culprits.push_back(name(c));
  return object;
}

}  // namespace

Lines render_drift(const WitnessCharts& charts) {
  const auto verdict = charts.verdict();
  if (!verdict) return {};
  Lines lines;
  for (const DriftAlarm& a : verdict->alarms)
    lines.push_back(
        fmt::format("! drift since shot {}, told at shot {}: {}", a.since, a.shot, words(a.chart)));
  for (const WitnessShift& shift : verdict->shifts)
    if (has_moved(shift)) lines.push_back(shift_words(shift));
  lines.push_back(cause_words(verdict->culprits));
  return lines;
}

Lines render_witnesses(const WitnessCharts& charts) {
  constexpr std::size_t kShotWidth = 8, kWidth = 14;
  Lines lines(1, left("shot", kShotWidth));
  for (const std::string_view column : kColumns) lines[0] += right(column, kWidth);
  for (std::size_t shot = 0; shot < charts.shots().size(); ++shot) {
    std::string values = left(charts.shot(shot), kShotWidth), sums = left("", kShotWidth);
    for (std::size_t w = 0; w < kWitnessCount; ++w) {
      const ChartPoint* p = point_of(charts, w, shot);
      values += right(p ? rounded(p->measured.value, p->measured.sd) : "-", kWidth);
      sums += right(p ? fmt::format("+{:.1f} -{:.1f}", p->upper, p->lower) : "", kWidth);
    }
    lines.push_back(values);
    lines.push_back(sums);
  }
  const ControlChart* any = nullptr;
  for (std::size_t w = 0; w < kWitnessCount && !any; ++w) any = charts.chart(static_cast<Witness>(w));
  if (any)
    lines.push_back(
        fmt::format("beneath each value the sums of either side; beyond {:.1f} it drifts", any->limit()));
  return lines;
}

ordered_json drift_json(const WitnessCharts& charts) {
  ordered_json object{{"charts", ordered_json::object()}};
  for (std::size_t w = 0; w < kWitnessCount; ++w)
    if (const ControlChart* chart = charts.chart(static_cast<Witness>(w)))
      object["charts"][std::string(kWitnessNames[w])] = chart_json(charts, *chart);
  const auto verdict = charts.verdict();
  object["drift"] = verdict ? verdict_json(*verdict) : ordered_json();
  return object;
}

}  // namespace strobe::host
