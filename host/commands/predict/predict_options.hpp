// The options of `strobe predict`. Single-threaded.
#pragma once

#include <memory>
#include <string>

#include "common/frontier/frontier.hpp"
#include "host/commands/predict/predict_model.hpp"

namespace CLI {
class App;
}

namespace strobe::host {

struct PredictOptions {
  PredictInput input;
  bool model_given = false;
  std::string tolerance;  ///< as typed; empty: none
  std::optional<double> deadline_us;
  std::string frontier_file;  ///< empty: the shipped one
  std::string trajectory_file;
  int samples = 0;
  bool json = false;

  bool chooses() const { return !tolerance.empty() || deadline_us.has_value(); }
  bool wants_trajectory() const { return samples > 0 || !trajectory_file.empty(); }
};

void add_predict_options(CLI::App& command, PredictOptions& options);

/// To be called after parsing: the first conflict between options, or an empty text. Sets model_given.
std::string find_conflict(const CLI::App& command, PredictOptions& options);

}  // namespace strobe::host
