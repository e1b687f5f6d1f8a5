// System calls made directly, past every interposed libc function: the preloaded library must neither meet
// itself nor a sanitizer that is not set up yet. Each returns its result or a negated errno and leaves errno
// alone.
#pragma once

#include <poll.h>
#include <signal.h>
#include <sys/types.h>
#include <time.h>

#include <cstddef>
#include <cstdint>

namespace strobe::sim::gpio::sys {

int open(const char* path, int flags, unsigned mode = 0);
int close(int fd);
long read(int fd, void* data, std::size_t size);
long write(int fd, const void* data, std::size_t size);
std::int64_t seek(int fd, std::int64_t offset, int whence);
int control(int fd, int command, long argument);
int ioctl(int fd, unsigned long request, void* argument);

struct FileId {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
};
int identify(int fd, FileId& id);

/// Open-file-description locks on one byte. `try_lock` returns -EAGAIN if another description has it.
int try_lock(int fd, std::int64_t byte, bool exclusive);
int unlock(int fd, std::int64_t byte);
bool is_locked(int fd, std::int64_t byte);  ///< by a description other than fd's

void* map_shared(int fd, std::size_t size);
void unmap(void* address, std::size_t size);

int clock_gettime(clockid_t clock, struct timespec* time);  ///< native, whatever is preloaded
std::int64_t now_ns();  ///< CLOCK_MONOTONIC of the machine; see rig_time.hpp
std::int64_t clock_ns(clockid_t clock);
inline struct timespec to_timespec(std::int64_t ns) {  ///< valid: not negative
  return {static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
}
void sleep_ns(std::int64_t duration);   ///< may end early
void futex_wake_all(const void* word);  ///< across processes
/// Sleeps while *word == expected, until an absolute instant of CLOCK_MONOTONIC.
void futex_wait(const void* word, std::uint32_t expected, std::int64_t until_ns);

int ppoll(struct pollfd* polled, nfds_t count, const struct timespec* timeout, const sigset_t* signals);
int signal_thread(int pid, int tid, int signal);

/// 1 if there is something to read or the other end is gone, 0 if not yet; it can wait for that.
int readable(int fd, bool waits);

/// Copies like the kernel's copy_from_user and copy_to_user: -EFAULT instead of a signal.
int copy_in(void* to, const void* user, std::size_t size);
int copy_out(void* user, const void* from, std::size_t size);

/// Holds back all signals of this thread: a handler must not run inside a simulated system call.
class NoSignals {
 public:
  NoSignals();
  ~NoSignals();
  NoSignals(const NoSignals&) = delete;
  NoSignals& operator=(const NoSignals&) = delete;

 private:
  std::uint64_t before_ = 0;
};

}  // namespace strobe::sim::gpio::sys
