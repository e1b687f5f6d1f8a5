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
  static Result<std::unique_ptr<TruthFile>> create(const std::filesystem::path& path, const Scene& scene,
                                                   std::uint64_t seed);

  /// Writes the exposure's line unless it was written before. shot_id 0: unknown.
  void write(const Exposure& exposure, int shot_id);

 private:
  TruthFile(const Scene& scene, std::uint64_t seed) : scene_(scene), seed_(seed) {}

  const Scene scene_;
  std::uint64_t seed_;
  std::mutex mutex_;
  std::ofstream file_;
  std::set<int> written_;  ///< numbers of exposures
};

}  // namespace strobe::sim
