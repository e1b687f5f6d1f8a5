// Finished exposures, looked up by time: between the thread that runs the rig and those of the tablet
// operator and the camera. Thread-safe; not for the real-time path (locks, allocates).
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

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

}  // namespace strobe::sim
