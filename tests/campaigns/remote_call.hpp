// Makes a thread of another process make a system call, or stand still: descriptors closed, threads ended and
// calls failing under a program that knows nothing of it. By ptrace(2); the right to trace it is needed. One
// thread. x86-64 only.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace strobe::ends {

/// The threads of a process, first to last.
std::vector<pid_t> threads_of(pid_t pid);

/// A thread that is held: it stands still from construction to destruction, whatever the others do.
class HeldThread {
 public:
  explicit HeldThread(pid_t thread);
  HeldThread(const HeldThread&) = delete;
  HeldThread& operator=(const HeldThread&) = delete;
  ~HeldThread();

  /// False if it is gone, may not be traced, or this is no x86-64.
  bool held() const { return held_; }

  /// What the system call returned, -errno included; nullopt if the thread could not make it.
  std::optional<std::int64_t> call(std::int64_t number, const std::array<std::int64_t, 6>& arguments = {});

  /// The thread makes exit(2), which does not return; others of its process go on.
  void end();

 private:
  pid_t thread_;
  bool held_ = false;
};

/// From now on a system call fails with this errno in all threads of the process that `thread` belongs to, and
/// does nothing. Tells whether it was done.
bool fail_system_call(HeldThread& thread, pid_t pid, int number, int error);

}  // namespace strobe::ends
