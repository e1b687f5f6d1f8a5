// What is timed, and beside what. The shipped loop: Sequencer, ShotPlayer, clock, LoopQueue and GpioInputs,
// GpioOutputs as strobed has them, in a process of its own with libgpiod on a simulated chip, fires dry shots
// one after the other.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/units/time.hpp"
#include "sim/gpiochip/chip.hpp"
#include "tests/benchmarks/timing/figures.hpp"

namespace strobe::benchmarks::timing {

struct LoopSettings {
  int seconds = 10, priority = 80;
  int cpu = -1;  ///< -1: any
  Duration period = milliseconds(3), spin = microseconds(200);
  std::optional<Duration> wake_ahead;  ///< none: the shipped rig file's
};

struct LoopRun {
  std::vector<Sample> issue;  ///< issue_start - commanded: what cyclictest measures of a wake-up
  double cpu_percent = 0.0;   ///< of one core, by the loop's thread, during a train
  int shots = 0;
  int aborted = 0;  ///< a flash would have been later than the rig file's limit; it counts as issued then
};

/// A simulated chip in memory, key on and e-stop released, on which nothing happens; with somebody who waits for
/// every change, as the simulated rig does.
class LoopFixture {
 public:
  LoopFixture();
  ~LoopFixture();

  /// std::runtime_error if the loop cannot run.
  LoopRun run(const LoopSettings& settings);

 private:
  struct Waiter;
  std::filesystem::path folder_;
  sim::Chip chip_;
  std::unique_ptr<Waiter> waiter_;
};

/// The shipped programs together, strobe-sim, strobed and strobe fire, from strobed's own journal: fires dry
/// shots (lamps and shutter only) for about `like.seconds`, with the shipped rig file; a shot with its pauses
/// takes about one. Of `like` only seconds, priority and CPU count. `strobed`: the program, or empty for the
/// one beside this; `time`: strobe-sim's --time. std::runtime_error if no flash was fired.
LoopRun run_programs(const LoopSettings& like, const std::filesystem::path& folder,
                     const std::filesystem::path& strobed = {}, const std::string& time = "real");

/// Runs cyclictest of Debian's rt-tests, the reference that the loop is compared with, with the same
/// priority, period and CPU. Its wake-ups are put half a millisecond off the kernel's tick and the freeze
/// detector, as the loop puts its flashes: left to chance it would do worse. std::runtime_error if it cannot
/// be run.
std::vector<Sample> run_cyclictest(const LoopSettings& like);

}  // namespace strobe::benchmarks::timing
