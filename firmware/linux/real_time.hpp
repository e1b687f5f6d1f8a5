// Real-time rights: locked memory, SCHED_FIFO, a CPU of its own, no deep sleep states. Set-up only, not
// real-time.
#pragma once

#include <sys/types.h>

#include <string>

#include "firmware/core/rig.hpp"

namespace strobe::firmware {

/// Holds /dev/cpu_dma_latency at 0 during its lifetime.
class LatencyRequest {
 public:
  LatencyRequest();
  LatencyRequest(const LatencyRequest&) = delete;
  LatencyRequest& operator=(const LatencyRequest&) = delete;
  ~LatencyRequest();
  const std::string& fault() const { return fault_; }  ///< empty if granted

 private:
  int fd_ = -1;
  std::string fault_;
};

/// Each returns one line that says what is wrong and what to do about it; empty if done.
std::string lock_memory();
std::string become_real_time(int priority);  ///< the calling thread, SCHED_FIFO
void become_ordinary();                      ///< the calling thread, SCHED_OTHER
std::string pin_to_cpu(int cpu);             ///< the calling thread; -1: does nothing
void allow_any_cpu(pid_t thread);            ///< another one, that waits for its CPU in vain
/// Keeps the calling thread and those it starts off the CPU, if there is another one; -1: does nothing.
void exclude_cpu(int cpu);

/// What is wrong with each right, as above; empty if it is granted.
struct RealTimeRights {
  std::string policy;
  std::string priority;
  std::string memory;
  std::string pinning;
  std::string latency;
  bool granted() const { return policy.empty() && priority.empty() && memory.empty() && pinning.empty(); }
};
/// Tries all of the above without keeping any (in a child process).
RealTimeRights probe_real_time(const Rig::RealTime& wanted);

/// For threads to come, those of libraries, too: with locked memory every page of every stack is resident.
void use_small_stacks();
/// Touches the calling thread's stack, so that no page of it faults later.
void prefault_stack();
/// Keeps freed memory in the process, so that an allocation after locking does not fault.
void keep_memory();

}  // namespace strobe::firmware
