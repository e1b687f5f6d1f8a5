// The libc functions through which a program knows the time and waits for it: rig time where one is kept
// (rig_time.hpp). The thread that asked for a real-time policy and waits with ppoll(2) is the loop.
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <spawn.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <new>

#include "sim/gpiochip/preload/device.hpp"
#include "sim/gpiochip/preload/next.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

namespace gpio = strobe::sim::gpio;

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

/// Null: the machine's time.
gpio::State* kept() {
  gpio::State* state = gpio::device().state;
  return state != nullptr && gpio::is_kept(*state) ? state : nullptr;
}

/// Null: rig time is not kept, nor was it, or the program has not begun.
gpio::State* known() {
  const gpio::Device* device = gpio::mapped_device_or_null();
  gpio::State* state = device != nullptr ? device->state : nullptr;
  const bool was_kept = state != nullptr && state->time.realtime_less_ns.load(std::memory_order_relaxed) != 0;
  return was_kept ? state : nullptr;
}

std::int64_t ns_of(const struct timespec& time) { return time.tv_sec * kSecond + time.tv_nsec; }

/// False: a clock of the thread or the process, which is the machine's.
bool read_clock(gpio::State& state, clockid_t clock, std::int64_t& ns) {
  switch (clock) {
    case CLOCK_MONOTONIC:
    case CLOCK_MONOTONIC_COARSE:
    case CLOCK_MONOTONIC_RAW:
      ns = gpio::now_ns(state);
      return true;
    case CLOCK_REALTIME:
    case CLOCK_REALTIME_COARSE:
      ns = gpio::realtime_ns(state);
      return true;
    case CLOCK_BOOTTIME:
      ns = gpio::boottime_ns(state);
      return true;
    default:
      return false;
  }
}

/// An instant of that clock as one of CLOCK_MONOTONIC.
std::int64_t monotonic_of(gpio::State& state, clockid_t clock, std::int64_t ns) {
  std::int64_t there = 0;
  return read_clock(state, clock, there) ? gpio::now_ns(state) + (ns - there) : ns;
}

/// 0, or EINTR with what is left.
int sleep_in_rig_time(gpio::State& state, std::int64_t duration_ns, struct timespec* left) {
  const std::int64_t until = gpio::now_ns(state) + duration_ns;
  const int before = errno;
  const int result = duration_ns > 0 ? gpio::wait_for(state, nullptr, 0, duration_ns) : 0;
  errno = before;
  if (result == 0) return 0;
  if (left != nullptr)
    *left = gpio::sys::to_timespec(until > gpio::now_ns(state) ? until - gpio::now_ns(state) : 0);
  return EINTR;
}

__attribute__((constructor)) void join() {
  gpio::State* state = kept();
  if (state == nullptr) return;
  gpio::prepare_waits();
  gpio::join_time(*state, getpid());
}

/// One that another thread has woken goes on once that one sleeps, as do those whom it wakes; nobody waits
/// for the mutex meanwhile.
void wait_for_turn(gpio::State& state, pthread_mutex_t* mutex) {
  pthread_mutex_unlock(mutex);
  gpio::wait_for_turn(state);
  pthread_mutex_lock(mutex);
}

using TimedWaitFunction = int(pthread_cond_t*, pthread_mutex_t*, clockid_t, const struct timespec*);

/// In slices, since nothing else than its own broadcast ends it.
int wait_for_condition(gpio::State& state, pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                       const struct timespec* until) {
  static auto* const native = gpio::next<TimedWaitFunction>("pthread_cond_clockwait");
  int result = ETIMEDOUT;
  const bool ended = gpio::wait_in_slices(state, monotonic_of(state, clock, ns_of(*until)), [&] {
    const struct timespec slice = gpio::sys::to_timespec(gpio::sys::now_ns() + 1'000'000);
    result = native(condition, mutex, CLOCK_MONOTONIC, &slice);
    return result != ETIMEDOUT;
  });
  if (!ended) return ETIMEDOUT;
  wait_for_turn(state, mutex);
  return result;
}

}  // namespace

STROBE_EXPORT int clock_gettime(clockid_t clock, struct timespec* time) noexcept {
  gpio::State* state = known();
  std::int64_t ns = 0;
  if (state == nullptr || !read_clock(*state, clock, ns)) return gpio::sys::clock_gettime(clock, time);
  *time = gpio::sys::to_timespec(ns);
  return 0;
}

STROBE_EXPORT int gettimeofday(struct timeval* time, void*) noexcept {
  struct timespec now {};
  clock_gettime(CLOCK_REALTIME, &now);
  *time = {now.tv_sec, now.tv_nsec / 1000};
  return 0;
}

STROBE_EXPORT time_t time(time_t* time) noexcept {
  struct timespec now {};
  clock_gettime(CLOCK_REALTIME, &now);
  if (time != nullptr) *time = now.tv_sec;
  return now.tv_sec;
}

STROBE_EXPORT int clock_nanosleep(clockid_t clock, int flags, const struct timespec* wanted,
                                  struct timespec* left) {
  gpio::State* state = kept();
  if (state == nullptr) {
    using Function = int(clockid_t, int, const struct timespec*, struct timespec*);
    static auto* const native = gpio::next<Function>("clock_nanosleep");
    return native(clock, flags, wanted, left);
  }
  if ((flags & TIMER_ABSTIME) == 0) return sleep_in_rig_time(*state, ns_of(*wanted), left);
  return sleep_in_rig_time(*state, monotonic_of(*state, clock, ns_of(*wanted)) - gpio::now_ns(*state),
                           nullptr);
}

STROBE_EXPORT int nanosleep(const struct timespec* wanted, struct timespec* left) {
  const int result = clock_nanosleep(CLOCK_REALTIME, 0, wanted, left);
  if (result == 0) return 0;
  errno = result;
  return -1;
}

STROBE_EXPORT int poll(struct pollfd* polled, nfds_t count, int timeout_ms) {
  gpio::State* state = timeout_ms == 0 ? nullptr : kept();
  if (state != nullptr)
    return gpio::wait_for(*state, polled, count, timeout_ms < 0 ? -1 : std::int64_t{timeout_ms} * 1'000'000);
  using Function = int(struct pollfd*, nfds_t, int);
  static auto* const native = gpio::next<Function>("poll");
  return native(polled, count, timeout_ms);
}
STROBE_EXPORT int __poll_chk(struct pollfd* polled, nfds_t count, int timeout_ms, size_t) {
  return poll(polled, count, timeout_ms);
}

STROBE_EXPORT int ppoll(struct pollfd* polled, nfds_t count, const struct timespec* timeout,
                        const sigset_t* signals) {
  gpio::State* state = kept();
  if (state == nullptr) {
    using Function = int(struct pollfd*, nfds_t, const struct timespec*, const sigset_t*);
    static auto* const native = gpio::next<Function>("ppoll");
    return native(polled, count, timeout, signals);
  }
  gpio::become_loop(*state);
  return gpio::wait_for(*state, polled, count, timeout == nullptr ? -1 : ns_of(*timeout), signals);
}
// What ppoll() becomes under _FORTIFY_SOURCE.
STROBE_EXPORT int __ppoll_chk(struct pollfd* polled, nfds_t count, const struct timespec* timeout,
                              const sigset_t* signals, size_t) {
  return ppoll(polled, count, timeout, signals);
}

STROBE_EXPORT int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                                         const struct timespec* until) {
  gpio::State* state = kept();
  if (state != nullptr) return wait_for_condition(*state, condition, mutex, clock, until);
  static auto* const native = gpio::next<TimedWaitFunction>("pthread_cond_clockwait");
  return native(condition, mutex, clock, until);
}

STROBE_EXPORT int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                                         const struct timespec* until) {
  gpio::State* state = kept();
  if (state != nullptr) return wait_for_condition(*state, condition, mutex, CLOCK_REALTIME, until);
  using Function = int(pthread_cond_t*, pthread_mutex_t*, const struct timespec*);
  static auto* const native = gpio::next_of_condition<Function>("pthread_cond_timedwait");
  return native(condition, mutex, until);
}

STROBE_EXPORT int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  using Function = int(pthread_cond_t*, pthread_mutex_t*);
  static auto* const native = gpio::next_of_condition<Function>("pthread_cond_wait");
  const int result = native(condition, mutex);
  if (gpio::State* state = kept()) wait_for_turn(*state, mutex);
  return result;
}

namespace {

struct Start {
  void* (*run)(void*);
  void* argument;
};

void* run_in_turn(void* started) {
  const Start start = *static_cast<Start*>(started);
  delete static_cast<Start*>(started);
  if (gpio::State* state = kept()) gpio::wait_for_turn(*state);
  return start.run(start.argument);
}

}  // namespace

STROBE_EXPORT int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*),
                                 void* argument) noexcept {
  using Function = int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static auto* const native = gpio::next<Function>("pthread_create");
  if (kept() == nullptr) return native(thread, attributes, run, argument);
  auto* const start = new (std::nothrow) Start{run, argument};
  if (start == nullptr) return EAGAIN;
  const int result = native(thread, attributes, run_in_turn, start);
  if (result != 0) delete start;
  return result;
}

STROBE_EXPORT int pthread_setschedparam(pthread_t thread, int policy,
                                        const struct sched_param* wanted) noexcept {
  using Function = int(pthread_t, int, const struct sched_param*);
  static auto* const native = gpio::next<Function>("pthread_setschedparam");
  // Whether it is granted or not: a machine may lack the right, rig time stands in for it.
  if (pthread_equal(thread, pthread_self()) != 0)
    gpio::note_real_time((policy & ~SCHED_RESET_ON_FORK) == SCHED_FIFO);
  return native(thread, policy, wanted);
}

// A child takes part from its first instruction on.
namespace {

void join_child(pid_t child) {
  gpio::State* state = kept();
  if (state != nullptr && child > 0) gpio::join_time(*state, child);
}

template <typename Spawn>
int spawn(Spawn* native, pid_t* child, const char* path, const posix_spawn_file_actions_t* actions,
          const posix_spawnattr_t* attributes, char* const* arguments, char* const* environment) {
  pid_t made = 0;
  const int result = native(&made, path, actions, attributes, arguments, environment);
  if (result != 0) return result;
  join_child(made);
  if (child != nullptr) *child = made;
  return 0;
}

}  // namespace

STROBE_EXPORT pid_t fork() noexcept {
  using Function = pid_t();
  static auto* const native = gpio::next<Function>("fork");
  const pid_t child = native();
  join_child(child == 0 ? getpid() : child);
  return child;
}

// A wrapper cannot return twice on one stack.
STROBE_EXPORT pid_t vfork() noexcept { return fork(); }

STROBE_EXPORT int posix_spawn(pid_t* child, const char* path, const posix_spawn_file_actions_t* actions,
                              const posix_spawnattr_t* attributes, char* const* arguments,
                              char* const* environment) {
  static auto* const native = gpio::next<decltype(posix_spawn)>("posix_spawn");
  return spawn(native, child, path, actions, attributes, arguments, environment);
}
STROBE_EXPORT int posix_spawnp(pid_t* child, const char* file, const posix_spawn_file_actions_t* actions,
                               const posix_spawnattr_t* attributes, char* const* arguments,
                               char* const* environment) {
  static auto* const native = gpio::next<decltype(posix_spawnp)>("posix_spawnp");
  return spawn(native, child, file, actions, attributes, arguments, environment);
}
