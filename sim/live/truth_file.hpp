// The file of true values, one JSON object per line, flushed per shot. Thread-safe.
#pragma once

#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>
#include <string>

#include "common/result.hpp"
#include "sim/rig/exposure.hpp"

namespace strobe::sim {

class TruthFile {
 public:
  /// An empty path writes nothing. Fails if the file cannot be made.
  static Result<std::unique_ptr<TruthFile>> create(const std::filesystem::path& path, const Scene& scene);

  /// Writes the exposure's line unless it was written before. shot_id 0: unknown.
  void write(const Exposure& exposure, int shot_id);

 private:
  explicit TruthFile(const Scene& scene) : scene_(scene) {}

  const Scene scene_;
  std::mutex mutex_;
  std::ofstream file_;
  std::set<int> written_;  ///< numbers of exposures
};

}  // namespace strobe::sim
