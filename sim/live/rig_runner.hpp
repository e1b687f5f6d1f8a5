// Runs a rig on a chip: a thread of its own that waits for line changes, hands them to the rig, and drives
// the inputs as soon as their instants have passed, with their exact stamps. The thread requests SCHED_FIFO
// priority and continues without it if that is not permitted. Start and stop from one thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "sim/gpiochip/chip.hpp"
#include "sim/live/exposures.hpp"
#include "sim/rig/rig.hpp"

namespace strobe::sim {

class RigRunner {
 public:
  /// `chip` is this runner's own, created or attached to; changes from now on are seen. `exposure_store` must
  /// outlive the runner.
  RigRunner(Chip chip, const Scene& scene, std::uint64_t seed, ExposureStore& exposure_store,
            bool record_changes, const Model& model = Model::full());
  ~RigRunner();
  RigRunner(const RigRunner&) = delete;
  RigRunner& operator=(const RigRunner&) = delete;

  /// Of each change of a line, by the runner's thread before it goes on. Before start().
  void tell_changes(std::function<void(const std::vector<Change>&)> listener) {
    listener_ = std::move(listener);
  }
  void start();
  /// Ends the thread and stores an exposure still in progress.
  void stop();

  /// Of the rig's other threads.
  RigClock clock() const { return chip_.clock(); }
  /// Before the program under test becomes what it is.
  void take_along() const { chip_.join_time(); }

  /// All changes of all lines, if they were to be recorded. After stop() only.
  const std::vector<Change>& changes() const { return recorded_; }

 private:
  void run(const std::atomic<bool>& stopping);
  void take_changes(MonoTime deadline);
  void give_drives(MonoTime now);

  Chip chip_;
  Rig rig_;
  ExposureStore& exposure_store_;
  bool record_changes_;
  ChangeCursor cursor_;
  std::function<void(const std::vector<Change>&)> listener_;
  std::vector<Change> fresh_;
  std::vector<Change> recorded_;
  std::vector<Drive> drives_;
  std::vector<Exposure> exposures_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace strobe::sim
