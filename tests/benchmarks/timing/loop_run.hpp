// The shipped loop, timed: Sequencer, ShotPlayer, clock, LoopQueue and GpioInputs, GpioOutputs as strobed has them, in a
// process of its own with libgpiod on a simulated chip, fires dry shots one after the other.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "common/units/time.hpp"
#include "sim/gpiochip/chip.hpp"
#include "tests/benchmarks/timing/sample.hpp"

namespace strobe::benchmarks::timing {

enum class Outputs {
  chip,  ///< set through libgpiod on the simulated chip
  none   ///< set nothing: what is left is the loop's own
};

struct LoopSettings {
  int seconds = 10, priority = 80;
  int cpu = -1;  ///< -1: any
  Duration period = milliseconds(3), spin = microseconds(200);
  std::optional<Duration> wake_ahead;  ///< none: the shipped rig file's
  Outputs outputs = Outputs::chip;
  bool tick_avoidance = true;  ///< false: shots start wherever they fall relative to the kernel's tick
};

struct LoopRun {
  std::vector<Sample> issue;  ///< issue_start - commanded: what cyclictest measures of a wake-up
  std::vector<Sample> done;   ///< issue_end - commanded: with the set-values call
  std::vector<Sample> call;   ///< issue_end - issue_start
  double cpu_percent = 0.0;   ///< of one core, by the loop's thread, during a train
  int shots = 0;
  int aborted = 0;  ///< a flash would have been later than the rig file's limit; it counts as issued then
};

/// A simulated chip in memory, key on and e-stop released, on which nothing happens; with somebody who waits
/// for every change, as the simulated rig does, if wanted.
class LoopFixture {
 public:
  explicit LoopFixture(bool rig_waits);
  ~LoopFixture();

  /// std::runtime_error if the loop cannot run.
  LoopRun run(const LoopSettings& settings);

 private:
  struct Waiter;
  std::filesystem::path folder_;
  sim::Chip chip_;
  std::unique_ptr<Waiter> waiter_;
};

}  // namespace strobe::benchmarks::timing
