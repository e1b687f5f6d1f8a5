// The whole way from a shot to its readout, held against the truth: rendered photograph, digitizer, match of
// images to flashes, best estimator; and what each measurement contributes to the error. Prints; uses several
// threads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/digitize/core/types.hpp"

namespace strobe::studies::digitize {

struct ChainOptions {
  std::vector<std::string> scenes;  ///< empty: the court-pace scene and the thesis's conditions
  int shots = 1;
  std::uint64_t seed = 1;
  strobe::digitize::Effort effort = strobe::digitize::Effort::standard;
  int jobs = 1;
  double scale_sd = 0.0005;         ///< of the calibrated scale, relative
  double ball_diameter_sd_m = 0.0;  ///< by how much the ball differs from what the rig file says
  std::string kept_in;              ///< Take::kept_in
};

Result<void> study_chain(const ChainOptions& options);

}  // namespace strobe::studies::digitize
