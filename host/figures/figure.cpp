#include "host/figures/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace strobe::figures {

namespace {

constexpr double kLargest = 1e100;
constexpr double kMargin = 0.06;  // of the span, on either side
constexpr int kMaxNames = 25;     // on an axis

bool drawable(double value) { return std::abs(value) <= kLargest; }  // false for NaN

/// The smallest of 1, 2, 5 times a power of ten that gives at most six intervals.
double round_step(double span) {
  const double least = span / 6.0;
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= least * (1.0 - 1e-9)) return factor * power;
  return 10.0 * power;
}

std::string tick_text(double at, double step) {
  if (std::abs(at) < 1e-9 * step) at = 0.0;  // no "-0"
  const int decimals = static_cast<int>(std::ceil(-std::log10(step) - 1e-9));
  if (decimals > 6 || std::abs(at) >= 1e6) return fmt::format("{:.6g}", at);
  return fmt::format("{:.{}f}", at, std::max(0, decimals));
}

std::vector<double> values_of(const Panel& panel, bool of_x) {
  std::vector<double> values;
  for (const Series& series : panel.series) {
    for (const PlotPoint& p : series.points) {
      if (of_x) {
        values.push_back(p.x);
        continue;
      }
      if (panel.x_range && (p.x < panel.x_range->first || p.x > panel.x_range->second)) continue;
      values.insert(values.end(), {p.y, p.low, p.high});
    }
  }
  if (!of_x && panel.zero_line) values.push_back(0.0);
  return values;
}

/// Where no range is stated, or it cannot be drawn, by the values.
Axis axis_of(const Panel& panel, const std::optional<std::pair<double, double>>& range, bool of_x) {
  if (of_x ? panel.log_x : panel.log_y) return log_axis_for(values_of(panel, of_x));
  if (range && drawable(range->first) && drawable(range->second) && range->first < range->second)
    return axis_between(range->first, range->second);
  return axis_for(values_of(panel, of_x));
}

/// At most kMaxNames of them.
Axis named_axis(const std::vector<std::string>& names) {
  const int count = static_cast<int>(names.size());
  Axis axis{.low = 0.5, .high = std::max(1, count) + 0.5};
  const int step = (count + kMaxNames - 1) / kMaxNames;
  for (int i = 0; i < count; i += std::max(1, step))
    axis.ticks.push_back({i + 1.0, names[static_cast<std::size_t>(i)]});
  return axis;
}

bool has_point(const Panel& panel) {
  for (const Series& series : panel.series)
    for (const PlotPoint& p : series.points)
      if (drawable(p.x) && drawable(p.y)) return true;
  return false;
}

}  // namespace

double Axis::position(double value) const {
  assert(low < high);
  if (logarithmic) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

Axis axis_between(double low, double high) {
  Axis axis{.low = low, .high = high};
  const double step = round_step(high - low);
  const double first = std::ceil(low / step - 1e-9);
  for (int i = 0; i < 20; ++i) {
    const double at = (first + i) * step;
    if (at > high + 1e-9 * step) break;
    if (std::isfinite(at)) axis.ticks.push_back({at, tick_text(at, step)});
  }
  return axis;
}

Axis axis_for(const std::vector<double>& values) {
  double low = kLargest, high = -kLargest;
  for (const double value : values) {
    if (!drawable(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (low > high) return axis_between(0.0, 1.0);
  const double size = std::max(std::abs(low), std::abs(high));
  double span = high - low;
  if (span <= 1e-9 * size || span < 1e-100) {  // equal, but for rounding
    const double room = size > 1e-90 ? 0.05 * size : 0.5;
    return axis_between(low - room, high + room);
  }
  return axis_between(low - kMargin * span, high + kMargin * span);
}

Axis log_axis_for(const std::vector<double>& values) {
  double low = kLargest, high = 0.0;
  for (const double value : values) {
    if (!drawable(value) || !(value >= 1.0 / kLargest)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (low > high) low = 0.1, high = 1.0;
  const double room = std::pow(std::max(high / low, 2.0), kMargin);
  Axis axis{.low = low / room, .high = high * room, .logarithmic = true};
  const double decades = std::log10(axis.high / axis.low);
  const int step = static_cast<int>(std::ceil(decades / 10.0));
  const int first = step * static_cast<int>(std::floor(std::log10(axis.low) / step));
  for (int power = first; std::pow(10.0, power) <= axis.high; power += step) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double at = factor * std::pow(10.0, power);
      if (factor > 1.0 && decades > 2.0) break;
      if (at >= axis.low && at <= axis.high) axis.ticks.push_back({at, fmt::format("{:g}", at)});
    }
  }
  return axis;
}

Chart make_chart(std::string key, Figure figure, const std::vector<std::string>& x_names) {
  Chart chart{.key = std::move(key),
              .title = std::move(figure.title),
              .caption = std::move(figure.caption),
              .columns = std::clamp(figure.columns, 1, 4),
              .legend_columns = std::max(1, figure.legend_columns),
              .panels = {}};
  for (Panel& panel : figure.panels) {
    ChartPanel out;
    out.x = x_names.empty() ? axis_of(panel, panel.x_range, true) : named_axis(x_names);
    out.y = axis_of(panel, panel.y_range, false);
    out.is_empty = !has_point(panel);
    out.panel = std::move(panel);
    chart.panels.push_back(std::move(out));
  }
  return chart;
}

}  // namespace strobe::figures
