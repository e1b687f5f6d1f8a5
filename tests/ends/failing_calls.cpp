#include "tests/ends/failing_calls.hpp"

#include <sys/syscall.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace strobe::ends {
namespace {

struct Call {
  const char* name;
  int number;
};

// What the firmware's threads use while they work; exit(2) and rt_sigreturn(2) cannot fail.
constexpr std::array kCalls{Call{"read", SYS_read},
                            Call{"write", SYS_write},
                            Call{"pwrite64", SYS_pwrite64},
                            Call{"fdatasync", SYS_fdatasync},
                            Call{"fallocate", SYS_fallocate},
                            Call{"ftruncate", SYS_ftruncate},
                            Call{"openat", SYS_openat},
                            Call{"ioctl", SYS_ioctl},
                            Call{"sendto", SYS_sendto},
                            Call{"sendmsg", SYS_sendmsg},
                            Call{"recvmsg", SYS_recvmsg},
                            Call{"ppoll", SYS_ppoll},
#ifdef SYS_poll  // newer architectures have ppoll(2) only
                            Call{"poll", SYS_poll},
#endif
                            Call{"clock_nanosleep", SYS_clock_nanosleep},
                            Call{"futex", SYS_futex},
                            Call{"mmap", SYS_mmap},
                            Call{"munmap", SYS_munmap},
                            Call{"kill", SYS_kill},
                            Call{"wait4", SYS_wait4},
                            Call{"rt_sigtimedwait", SYS_rt_sigtimedwait}};
constexpr std::array kErrors{EIO, ENOSPC, EINTR, EAGAIN, ENOMEM, EBADF, EPERM};

}  // namespace

FailingCall failing_call(int argument) {
  const auto k = static_cast<std::size_t>(argument);
  const Call& call = kCalls[k % kCalls.size()];
  const int error = kErrors[k / kCalls.size() % kErrors.size()];
  return {call.name, call.number, strerrorname_np(error), error};
}

}  // namespace strobe::ends
