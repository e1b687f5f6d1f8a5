// The digitizer's accuracy on rendered photographs, condition by condition, with OpenCV's HoughCircles beside
// it. Prints; uses several threads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/digitize/core/types.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::studies::digitize {

struct AccuracyOptions {
  std::vector<std::string> scenes;  ///< empty: the thesis's conditions
  int shots = 1;
  int first_shot = 1;
  std::uint64_t seed = 1;
  strobe::digitize::Effort effort = strobe::digitize::Effort::standard;
  int rounds = 2;
  int jobs = 1;  ///< photographs at a time; with more than one, times are not told
  bool hough = true;
  std::string save;     ///< folder for what went wrong; empty: none
  std::string kept_in;  ///< Take::kept_in
  std::string csv;      ///< one line an image; empty: none
};

/// The named scenes, or the thesis's conditions.
Result<std::vector<std::string>> scene_names(const std::vector<std::string>& named);
Result<std::vector<sim::Scene>> load_scenes(const std::vector<std::string>& names);

Result<void> study_accuracy(const AccuracyOptions& options);

}  // namespace strobe::studies::digitize
