// Finished exposures, looked up by time: between the thread that runs the rig and those of the tablet
// operator and the camera. Thread-safe; not for the real-time path (locks, allocates).
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "sim/rig/exposure.hpp"

namespace strobe::sim {

class ExposureStore {
 public:
  void add(Exposure exposure);

  /// The exposure in progress: the instant of the line's change that began it.
  void set_exposing(std::optional<MonoTime> since);

  struct Found {
    std::shared_ptr<const Exposure> exposure;  ///< null: none
    bool wait = false;                         ///< one in progress may be it
  };
  /// The first exposure begun within the two instants.
  Found begun_within(MonoTime earliest, MonoTime latest) const;

  std::vector<std::shared_ptr<const Exposure>> all() const;

 private:
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<const Exposure>> exposures_;
  std::optional<MonoTime> exposing_since_;
};

/// The file of true values, one JSON object per line, flushed per shot. Thread-safe.
class TruthFile {
 public:
  /// An empty path writes nothing. Fails if the file cannot be made.
  static Result<std::unique_ptr<TruthFile>> create(const std::filesystem::path& path, const Scene& scene);

  /// From now on lines include the photographs that the camera takes (sim/photograph).
  void include_photographs(std::uint64_t seed) { photograph_seed_ = seed; }

  /// Writes the exposure's line unless it was written before. shot_id 0: unknown.
  void write(const Exposure& exposure, int shot_id);
  /// No more lines. Fails if not all could be written.
  Result<void> close();

 private:
  explicit TruthFile(const Scene& scene) : scene_(scene) {}

  std::string line(const Exposure& exposure, int shot_id) const;

  const Scene scene_;
  std::optional<std::uint64_t> photograph_seed_;
  std::mutex mutex_;
  std::filesystem::path path_;
  std::ofstream file_;
  std::set<int> written_;  ///< numbers of exposures
};

}  // namespace strobe::sim
