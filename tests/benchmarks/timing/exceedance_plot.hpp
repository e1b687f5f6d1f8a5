// Curves drawn into an SVG.
#pragma once

#include <string>
#include <vector>

namespace strobe::benchmarks::timing {

struct Curve {
  std::string title;
  std::vector<double> x;
  std::vector<double> y;
};

struct Panel {
  std::string title, x_label, y_label;
  bool log_x = true, log_y = true;
  std::vector<Curve> curves;
};

/// The share of values that are above each, for values from 1 ns up.
Curve exceedance(const std::string& title, std::vector<double> values);

/// One panel beside the other, with the numbers in a .csv beside the file. std::runtime_error if one cannot be written.
void draw(const std::string& svg, const std::vector<Panel>& panels);

}  // namespace strobe::benchmarks::timing
