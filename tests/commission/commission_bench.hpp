// A simulated rig that is to be commissioned, the shipped programs on it, and a person who does what `strobe commission`
// asks for. The rig file is that of a sound rig; scene or rig file are then made wrong. Everything is in a temporary
// folder. One thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace strobe::commission_bench {

struct BenchOptions {
  std::string scene;  ///< TOML put after `inherits = "commission"`: what the rig truly is
  std::vector<std::pair<std::string, std::string>>
      rig_edits;           ///< texts replaced in the rig file; each must be there
  std::string rig_tables;  ///< TOML put after the rig file
  std::uint64_t seed = 1;
  int balls = 9;
  std::vector<std::string> only;  ///< steps; empty: all
  std::filesystem::path keep;     ///< where the folder is copied to; empty: nowhere
};

struct Outcome {
  std::vector<nlohmann::json> steps;  ///< as printed
  std::string err;                    ///< of strobe commission
  std::string trouble;                ///< why there is no outcome; empty: there is one
  double seconds = 0.0;

  const nlohmann::json* step(const std::string& id) const;
  /// Of steps that failed: "id (fault)", in their order.
  std::vector<std::string> failures() const;
};

Outcome commission(const BenchOptions& options);

}  // namespace strobe::commission_bench
