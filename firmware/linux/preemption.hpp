// How far the kernel lets a real-time thread interrupt other programs' system calls, which bounds how late a
// wake-up comes on a busy CPU. Set-up only, not real-time.
#pragma once

#include <string>

#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

enum class Preemption {
  none,       ///< a wake-up waits until a system call on its CPU returns or blocks
  voluntary,  ///< or reaches an explicit preemption point
  full,       ///< until locks are released and interrupt handlers end (also: lazy)
  real_time,  ///< PREEMPT_RT: those are preempted, too
  unknown     ///< cannot be read
};

struct PreemptionModel {
  Preemption model = Preemption::unknown;
  std::string source;       ///< the file it was read from
  bool switchable = false;  ///< by preempt=... on the kernel's command line, or by root at run time
};

/// From /sys/kernel/realtime, the kernel's version, and for one built with PREEMPT_DYNAMIC: debugfs, the
/// command line, the kernel's configuration in /boot, in this order. Safe from any thread.
PreemptionModel read_preemption(const SystemFiles& files);

}  // namespace strobe::firmware
