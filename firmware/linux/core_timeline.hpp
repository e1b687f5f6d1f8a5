// From what the kernel recorded on some CPUs to what had the CPU instead of a thread. Pure; allocates;
// thread-safe.
#pragma once

#include <sys/types.h>

#include <set>
#include <vector>

#include "firmware/linux/core_watch.hpp"

namespace strobe::firmware {

struct CoreRecord {
  enum class Kind {
    switched,    ///< from the thread `from` to `to`; 0: idle
    woken,       ///< the watched thread may run from now on
    page_fault,  ///< of the watched thread, for which it slept, is over
    interrupt_begin,
    interrupt_end,
    softirq_begin,
    softirq_end
  };
  MonoTime at;
  int cpu = 0;
  Kind kind = Kind::switched;
  pid_t from = 0;
  pid_t to = 0;
  bool preempted = false;  ///< `from` would have gone on
  int number = 0;          ///< of the interrupt or softirq
};

/// All that happened on `cpus` from `since` on.
struct CoreTimeline {
  std::set<int> cpus;
  MonoTime since;
  bool tells_wakings = false;  ///< otherwise none is recorded
  std::vector<CoreRecord> records;
};

/// A culprit that has a number yet instead of a name: of the thread, the interrupt or the softirq.
struct NumberedCulprit {
  Culprit::Kind kind = Culprit::Kind::unknown;
  int number = 0;
  Duration took{};
};

/// What had the thread's CPU for most of [from, to] while the thread could have run, or what it waited for.
NumberedCulprit find_culprit(CoreTimeline timeline, pid_t thread, MonoTime from, MonoTime to);

}  // namespace strobe::firmware
