// How far conditions may go until the digitizer breaks, one at a time, and whether it then says so. Prints,
// writes files; uses several threads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/digitize/core/types.hpp"
#include "tests/studies/digitize/score.hpp"

namespace strobe::studies::digitize {

struct RobustnessOptions {
  std::vector<std::string> scenes;  ///< empty: three of the thesis's conditions
  std::vector<std::string> axes;    ///< empty: all
  int shots = 2;                    ///< of each scene at each point
  std::uint64_t seed = 1;
  strobe::digitize::Effort effort = strobe::digitize::Effort::standard;
  int jobs = 1;
  std::string csv;   ///< empty: none
  std::string plot;  ///< FILE.svg or FILE.png; empty: none
};

/// One condition of an axis and what was measured under it.
struct RobustnessPoint {
  std::string axis;
  double value = 0.0;
  std::string label;
  Score score;
  TimeCount times;
};

/// Names of the axes, and whether drawn logarithmically.
struct RobustnessAxis {
  std::string name;
  std::string what;
  bool logarithmic = false;
};
const std::vector<RobustnessAxis>& robustness_axes();

Result<void> study_robustness(const RobustnessOptions& options);

/// Draws the curves with gnuplot. Fails with one line if it is missing or does not draw.
Result<void> plot_robustness(const std::vector<RobustnessPoint>& points, const std::string& file);

}  // namespace strobe::studies::digitize
