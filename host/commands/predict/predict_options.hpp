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
  std::string tolerance;  ///< as written; empty: none
  std::optional<double> deadline_us;
  std::string frontier_file;  ///< empty: the shipped one
  std::string trajectory_file;
  int samples = 0;
  bool json = false;

  bool chooses() const { return !tolerance.empty() || deadline_us.has_value(); }
  bool course() const { return samples > 0 || !trajectory_file.empty(); }
};

void add_predict_options(CLI::App& command, PredictOptions& options);

/// After parsing: what of the options given does not go together, or an empty text. Notes whether a model was
/// given.
std::string conflict(const CLI::App& command, PredictOptions& options);

}  // namespace strobe::host
