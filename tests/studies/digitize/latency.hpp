// From the rename of a photograph into the camera's folder to its shot's readout, through what `strobe live`
// runs: the folder's watcher, the matching, the reader's thread, the session. Prints; writes files into a
// temporary folder.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace strobe::studies::digitize {

struct LatencyOptions {
  std::vector<std::string> scenes;  ///< empty: the thesis's conditions
  int photographs = 21;             ///< of the scenes in turn
  int rounds = 1;                   ///< each photograph arrives so often; the least of its times counts
  std::uint64_t seed = 1;
  std::vector<std::string> efforts{"fast", "standard"};
  std::string kept_in;  ///< Take::kept_in
};

Result<void> study_latency(const LatencyOptions& options);

}  // namespace strobe::studies::digitize
