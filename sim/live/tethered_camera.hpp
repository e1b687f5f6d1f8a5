// The rig's camera as a tethered one: after each exposure its photograph appears in a folder, complete, under
// a new name (exposure-0001.tif; numbers continue after existing files). A thread of its own. Start and stop
// from one thread.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "common/result.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/live/exposures.hpp"

namespace strobe::sim {

class TetheredCamera {
 public:
  /// Makes the folder if it is missing; fails if that cannot be, or if the scene's photographs are too large.
  /// `exposure_store` must outlive the camera.
  static Result<std::unique_ptr<TetheredCamera>> create(const std::filesystem::path& folder,
                                                        const Scene& scene, std::uint64_t seed,
                                                        const ExposureStore& exposure_store,
                                                        RigClock clock = {});
  ~TetheredCamera();
  TetheredCamera(const TetheredCamera&) = delete;
  TetheredCamera& operator=(const TetheredCamera&) = delete;

  /// gives_way: rendering uses only the time that the rig and the program under test leave, as it must where
  /// they live in the machine's.
  void start(bool gives_way);
  /// Writes what is still to be written, and ends the thread. The first thing that could not be written.
  Result<void> stop();

 private:
  TetheredCamera(const std::filesystem::path& folder, const Scene& scene, std::uint64_t seed,
                 const ExposureStore& exposure_store, RigClock clock);
  void run(bool gives_way);
  /// Renders the exposures that are due; all of them if `at_once`.
  void take(bool at_once);
  void photograph(const Exposure& exposure);
  std::filesystem::path next_path();

  std::filesystem::path folder_;
  const Scene scene_;
  std::uint64_t seed_;
  const ExposureStore& exposure_store_;
  const RigClock clock_;
  std::vector<std::shared_ptr<const Exposure>> waiting_;
  std::size_t seen_ = 0;  ///< exposures of the exposure_store
  int last_number_ = 0;   ///< in a file's name
  Result<void> outcome_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace strobe::sim
