// The rig's camera as a tethered one: when an exposure is over its photograph appears in a folder, whole,
// under a name of its own (exposure-0001.tif, never over an older file: names go on counting). A thread of
// its own at the lowest niceness, so that rendering takes only what the rig and the program under test leave.
// Start and stop from one thread.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "common/result.hpp"
#include "sim/live/darkroom.hpp"

namespace strobe::sim {

class Photographer {
 public:
  /// Makes the folder if it is missing; fails if that cannot be, or if the scene's photographs are too large.
  /// `darkroom` must outlive the photographer.
  static Result<std::unique_ptr<Photographer>> create(const std::filesystem::path& folder, const Scene& scene,
                                                      std::uint64_t seed, const Darkroom& darkroom);
  ~Photographer();
  Photographer(const Photographer&) = delete;
  Photographer& operator=(const Photographer&) = delete;

  void start();
  /// Writes what is still to be written, and ends the thread. The first thing that could not be written.
  Result<void> stop();

 private:
  Photographer(const std::filesystem::path& folder, const Scene& scene, std::uint64_t seed,
               const Darkroom& darkroom);
  void run();
  /// All exposures that are due; all of them whether due or not where `at_once`.
  void take(bool at_once);
  void photograph(const Exposure& exposure);
  std::filesystem::path next_path();

  std::filesystem::path folder_;
  const Scene scene_;
  std::uint64_t seed_;
  const Darkroom& darkroom_;
  std::vector<std::shared_ptr<const Exposure>> waiting_;
  std::size_t seen_ = 0;  ///< exposures of the darkroom
  int last_number_ = 0;   ///< in a file's name
  Result<void> outcome_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace strobe::sim
