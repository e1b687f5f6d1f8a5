// A figure with its axes, ready to be drawn: every number that the drawing shows is in it. Pure; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/thesis/figures/plot.hpp"

namespace strobe::lab_report {

struct Tick {
  double at = 0.0;
  std::string text;
};

struct Axis {
  double low = 0.0;  ///< low < high, both finite
  double high = 1.0;
  std::vector<Tick> ticks;  ///< ascending, within
};

struct ChartPanel {
  report::Panel panel;
  Axis x, y;
  bool is_empty = false;  ///< nothing to draw
};

struct Chart {
  std::string key;
  std::string title;
  std::string caption;
  int columns = 1;         ///< of panels, 1 to 4
  int legend_columns = 3;  ///< at least 1
  std::vector<ChartPanel> panels;
};

/// Room for all values, with ticks at round numbers; where they are all equal, some about them. Values that are not
/// finite, or beyond 1e100 either way, are left out; without any it is 0 to 1.
Axis axis_for(const std::vector<double>& values);

/// The same limits, kept as they are; low < high, both finite.
Axis axis_between(double low, double high);

/// Axes by what the panels hold, or the ranges that they state. A panel with names has these as x ticks, at 1, 2, 3 ...
Chart make_chart(std::string key, report::Figure figure, const std::vector<std::string>& x_names = {});

}  // namespace strobe::lab_report
