// What kept a thread from running, by the kernel's own records of the CPUs that it may run on: context
// switches, and interrupts, softirqs and the thread's wakings where tracefs can be read (perf_event_open(2)).
// The kernel writes them into rings in which new records replace old ones; they are read only when a culprit
// is asked for, so that the watched CPUs pay for nothing but some 1 us at a context switch. Needs root,
// CAP_PERFMON or perf_event_paranoid below 1. Not real-time: allocates, reads /proc. One thread.
#pragma once

#include <sys/types.h>

#include <memory>
#include <set>
#include <string>

#include "common/result.hpp"
#include "common/units/time.hpp"

namespace strobe::firmware {

/// What had the CPU instead for the longest part of a span.
struct Culprit {
  enum class Kind {
    thread,        ///< another thread ran, name: "kworker/1:2 (pid 71)"
    interrupt,     ///< name: "interrupt 24 (eth0)"
    softirq,       ///< name: "NET_RX"
    page_fault,    ///< of the thread itself, which slept until it had the page
    waited,        ///< the thread slept: it was stopped or woken late
    core_stopped,  ///< the thread had the CPU, and yet time passed: the hypervisor, the firmware (SMI)
    unknown        ///< no record reaches back that far
  };
  Kind kind = Kind::unknown;
  std::string name;  ///< empty where the kind says it all
  Duration took{};   ///< within the span
};

/// "kworker/1:2 (pid 71) ran for 912 us".
std::string in_words(const Culprit& culprit);

/// False in a simulated rig, which has a time of its own: the kernel's records say nothing of it.
bool clock_is_the_kernels();

class CoreWatch {
 public:
  /// Watches the CPUs for the thread `tid`. Fails with one line where the kernel refuses.
  static Result<CoreWatch> open(const std::set<int>& cpus, pid_t tid);
  CoreWatch(CoreWatch&&) noexcept;
  CoreWatch& operator=(CoreWatch&&) noexcept;
  ~CoreWatch();

  /// Who kept the thread from running in [from, to]; best asked within a second.
  Culprit culprit(MonoTime from, MonoTime to);

 private:
  struct Rings;
  explicit CoreWatch(std::unique_ptr<Rings> rings);
  std::unique_ptr<Rings> rings_;
};

}  // namespace strobe::firmware
