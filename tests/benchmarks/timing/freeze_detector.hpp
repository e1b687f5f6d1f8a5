// Detects when the machine itself stands still, on every core.
//
// A virtual machine's host stops its cores for tens of milliseconds now and then, without telling the guest.
// Percentiles of a real-time loop mean something only outside such freezes, so they are given with and
// without them.
//
// By interrupts: each core takes a timer interrupt every millisecond and stamps it (CoreInterrupts). One
// that is 0.3 ms late or more means that the core stopped: nothing at all ran on it. A thread that wakes late
// because the kernel runs something else is no freeze: interrupts continue. The limit comes from a loaded
// machine (two cores copying memory and writing the disk): one interrupt in 60 was 20 us late, one in 500
// 0.2 ms, and between 0.3 and 0.6 ms their number hardly fell (43, 41 of 20,000), so that those have another
// cause. A stop longer than 1.3 ms is always detected, a shorter one if it meets an interrupt; what is not
// detected counts against what is measured.
//
// The kernel withholds such interrupts from a core without a tick, as an idle one is: so a thread of the
// lowest policy (SCHED_IDLE) spins on each core. A process that asks for no wake-up latency, as the loop and
// cyclictest do, keeps idle cores spinning anyhow.
//
// By wake-ups, where the kernel gives no such interrupts: a thread per core wakes every millisecond and
// records where it was late by 0.6 ms or more. This cannot distinguish a stop from the kernel's running
// something else. The threads run below the priority of what is measured; a spin of 200 us on their core
// stays below the limit.
//
// Both come at whole milliseconds of the clock, like the kernel's tick, so that what is measured can avoid
// them.
#pragma once

#include <time.h>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "common/units/time.hpp"

namespace strobe::benchmarks::timing {

struct CoreInterrupt {
  MonoTime at;
  bool in_kernel = false;  ///< what it interrupted
};

/// A timer interrupt every millisecond on one core, time-stamped by the kernel within the interrupt itself
/// (perf_event_open(2), the software event cpu-clock; CLOCK_MONOTONIC).
///
/// It comes at whole milliseconds, like the kernel's tick, whatever runs on the core: user code, a real-time
/// thread, or the kernel in a section without preemption. Only a core that stands still, or a rare section
/// with interrupts disabled, makes one late. Each costs some 2 us. Single-threaded.
class CoreInterrupts {
 public:
  /// Returns nullopt if the kernel refuses (it needs root, CAP_PERFMON or perf_event_paranoid below 1), or
  /// never starts them within 30 us of a whole millisecond. The calling thread moves to the core meanwhile,
  /// with real-time priority 1.
  static std::optional<CoreInterrupts> open(int cpu);
  CoreInterrupts(CoreInterrupts&& other) noexcept;
  CoreInterrupts& operator=(CoreInterrupts&&) = delete;
  ~CoreInterrupts();

  /// Appends the interrupts since the last call. Call it at least every 20 s: the kernel keeps no more.
  /// Throws std::runtime_error if some were lost.
  void take(std::vector<CoreInterrupt>& interrupts);

  static constexpr Duration kPeriod = milliseconds(1);

 private:
  CoreInterrupts(int fd, char* pages) : fd_(fd), pages_(pages) {}
  bool in_place();

  int fd_ = -1;
  char* pages_ = nullptr;
  std::uint64_t read_ = 0;
};

struct Freeze {
  MonoTime begin;  ///< of the last sign of life: up to a period too early
  MonoTime end;
  int cpu = 0;
};

/// The stops among a core's interrupts, in their order.
std::vector<Freeze> stops_of(std::span<const CoreInterrupt> interrupts, int cpu);

class FreezeDetector {
 public:
  enum class Method { interrupts, wake_ups };

  /// `priority`: SCHED_FIFO, of the threads that wake; ordinary scheduling where that is refused. By
  /// interrupts only where the kernel gives them: by() tells.
  explicit FreezeDetector(int priority, Method wanted = Method::wake_ups);
  ~FreezeDetector();
  FreezeDetector(const FreezeDetector&) = delete;
  FreezeDetector& operator=(const FreezeDetector&) = delete;

  Method by() const { return interrupts_.empty() ? Method::wake_ups : Method::interrupts; }

  /// Ends the watch and gives the freezes of all cores, sorted by their begin. std::runtime_error if the
  /// kernel dropped interrupts.
  std::vector<Freeze> stop();
  /// Of each core, after stop(); empty by wake-ups.
  const std::vector<std::vector<CoreInterrupt>>& interrupts() const { return taken_; }

  static constexpr Duration kPeriod = milliseconds(1);
  static constexpr Duration kLateInterrupt = microseconds(300);
  static constexpr Duration kLateWakeUp = microseconds(600);

 private:
  bool open_interrupts(std::size_t cores);
  void collect();
  void keep_ticking(int cpu);
  void watch(int cpu, int priority, std::vector<Freeze>& seen);

  std::atomic<bool> running_{true};
  std::vector<CoreInterrupts> interrupts_;
  std::vector<std::vector<CoreInterrupt>> taken_;
  std::string fault_;
  std::vector<std::vector<Freeze>> seen_;
  std::vector<std::thread> threads_;
};

/// "120 stops of a core, 793 ms in all, longest 40 ms": `by` tells what they were seen by.
std::string freezes_in_words(const std::vector<Freeze>& freezes, FreezeDetector::Method by);

/// Whether a core stood still for a hundredth of that time and more: such a machine gives no real time to
/// judge by.
bool stands_still_often(const std::vector<Freeze>& freezes, Duration watched);

/// Whether the span [from, to] touches a freeze of that core; cpu -1: of any.
bool within_freeze(const std::vector<Freeze>& freezes, MonoTime from, MonoTime to, int cpu = -1);

/// The benchmark's clock port. Thread-safe, real-time safe.
inline MonoTime now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return from_ns(t.tv_sec * 1'000'000'000 + t.tv_nsec);
}

}  // namespace strobe::benchmarks::timing
