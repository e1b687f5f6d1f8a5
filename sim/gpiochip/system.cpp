#include "sim/gpiochip/system.hpp"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/futex.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <climits>

namespace strobe::sim::gpio::sys {
namespace {

template <typename... Arguments>
long call(long number, Arguments... arguments) {
  const int before = errno;
  const long result = ::syscall(number, arguments...);
  const long answer = result < 0 ? -static_cast<long>(errno) : result;
  errno = before;
  return answer;
}

struct flock byte_lock(short type, std::int64_t byte) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = byte;
  lock.l_len = 1;
  return lock;
}

using ClockFunction = int(clockid_t, struct timespec*);
std::atomic<ClockFunction*> native_clock{nullptr};

/// libc's: the preloaded library has its own, and a program that has this one may be preloaded with it. Found
/// before the program begins: dlopen() allocates, and a sanitizer's allocator asks for the time while it
/// holds its lock.
__attribute__((constructor)) void find_native_clock() {
  void* const libc = ::dlopen("libc.so.6", RTLD_LAZY | RTLD_NOLOAD);
  native_clock.store(
      reinterpret_cast<ClockFunction*>(::dlsym(libc != nullptr ? libc : RTLD_NEXT, "clock_gettime")),
      std::memory_order_relaxed);
}

}  // namespace

int clock_gettime(clockid_t clock, struct timespec* time) {
  ClockFunction* const native = native_clock.load(std::memory_order_relaxed);
  return native != nullptr ? native(clock, time) : static_cast<int>(call(SYS_clock_gettime, clock, time));
}

int open(const char* path, int flags, unsigned mode) {
  return static_cast<int>(call(SYS_openat, AT_FDCWD, path, flags, mode));
}
int close(int fd) { return static_cast<int>(call(SYS_close, fd)); }
long read(int fd, void* data, std::size_t size) { return call(SYS_read, fd, data, size); }
long write(int fd, const void* data, std::size_t size) { return call(SYS_write, fd, data, size); }
std::int64_t seek(int fd, std::int64_t offset, int whence) { return call(SYS_lseek, fd, offset, whence); }
int control(int fd, int command, long argument) {
  return static_cast<int>(call(SYS_fcntl, fd, command, argument));
}
int ioctl(int fd, unsigned long request, void* argument) {
  return static_cast<int>(call(SYS_ioctl, fd, request, argument));
}

int identify(int fd, FileId& id) {
  struct stat status {};
  const int result = static_cast<int>(call(SYS_fstat, fd, &status));
  if (result == 0) id = {status.st_dev, status.st_ino};
  return result;
}

int try_lock(int fd, std::int64_t byte, bool exclusive) {
  struct flock lock = byte_lock(exclusive ? F_WRLCK : F_RDLCK, byte);
  return static_cast<int>(call(SYS_fcntl, fd, F_OFD_SETLK, &lock));
}

int unlock(int fd, std::int64_t byte) {
  struct flock lock = byte_lock(F_UNLCK, byte);
  return static_cast<int>(call(SYS_fcntl, fd, F_OFD_SETLK, &lock));
}

bool is_locked(int fd, std::int64_t byte) {
  struct flock lock = byte_lock(F_WRLCK, byte);
  return call(SYS_fcntl, fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

void* map_shared(int fd, std::size_t size) {
  // Populated at once: a real-time caller must not meet its first page faults inside a set.
  const long address =
      call(SYS_mmap, nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd, 0L);
  return address < 0 && address > -4096 ? nullptr : reinterpret_cast<void*>(address);
}
void unmap(void* address, std::size_t size) { call(SYS_munmap, address, size); }

std::int64_t clock_ns(clockid_t clock) {
  struct timespec now {};
  sys::clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}
std::int64_t now_ns() { return clock_ns(CLOCK_MONOTONIC); }

void sleep_ns(std::int64_t duration) {
  const struct timespec span = to_timespec(duration);
  call(SYS_nanosleep, &span, nullptr);
}

void futex_wake_all(const void* word) { call(SYS_futex, word, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0); }

void futex_wait(const void* word, std::uint32_t expected, std::int64_t until_ns) {
  const struct timespec until = to_timespec(until_ns);
  call(SYS_futex, word, FUTEX_WAIT_BITSET, expected, &until, nullptr, FUTEX_BITSET_MATCH_ANY);
}

int ppoll(struct pollfd* polled, nfds_t count, const struct timespec* timeout, const sigset_t* signals) {
  constexpr unsigned long kKernelSet = 8;  // bytes of the kernel's sigset_t
  struct timespec left {};
  if (timeout != nullptr) left = *timeout;  // the kernel writes what is left
  return static_cast<int>(
      call(SYS_ppoll, polled, count, timeout != nullptr ? &left : nullptr, signals, kKernelSet));
}

int signal_thread(int pid, int tid, int signal) {
  return static_cast<int>(call(SYS_tgkill, pid, tid, signal));
}

int readable(int fd, bool waits) {
  struct pollfd waiting {
    fd, POLLIN, 0
  };
  const struct timespec at_once {};
  return sys::ppoll(&waiting, 1, waits ? nullptr : &at_once, nullptr);
}

int copy_in(void* to, const void* user, std::size_t size) {
  const struct iovec local { to, size };
  const struct iovec remote { const_cast<void*>(user), size };
  const long copied = call(SYS_process_vm_readv, ::getpid(), &local, 1UL, &remote, 1UL, 0UL);
  return copied == static_cast<long>(size) ? 0 : -EFAULT;
}

int copy_out(void* user, const void* from, std::size_t size) {
  const struct iovec local { const_cast<void*>(from), size };
  const struct iovec remote { user, size };
  const long copied = call(SYS_process_vm_writev, ::getpid(), &local, 1UL, &remote, 1UL, 0UL);
  return copied == static_cast<long>(size) ? 0 : -EFAULT;
}

NoSignals::NoSignals() {
  const std::uint64_t all = ~std::uint64_t{0};
  call(SYS_rt_sigprocmask, SIG_SETMASK, &all, &before_, sizeof(before_));
}
NoSignals::~NoSignals() { call(SYS_rt_sigprocmask, SIG_SETMASK, &before_, nullptr, sizeof(before_)); }

}  // namespace strobe::sim::gpio::sys
