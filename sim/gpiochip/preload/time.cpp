// The libc functions through which the program under test knows the time: rig time where one is kept (rig_time.hpp).
// Its loop is the thread that asked for a real-time policy and waits with ppoll(2).
#include <dlfcn.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <time.h>

#include "sim/gpiochip/preload/device.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

#define STROBE_EXPORT extern "C" __attribute__((visibility("default")))

namespace gpio = strobe::sim::gpio;

namespace {

thread_local bool asked_for_real_time = false;

/// Null: the machine's time.
gpio::State* kept() {
  gpio::State* state = gpio::device().state;
  return state != nullptr && state->time.kept.load(std::memory_order_relaxed) != 0 ? state : nullptr;
}

struct timespec timespec_of(std::int64_t ns) {
  return {static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
}

template <typename Function>
Function* next(Function*& cache, const char* name) {
  Function* found = __atomic_load_n(&cache, __ATOMIC_RELAXED);
  if (found == nullptr) {
    found = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
    __atomic_store_n(&cache, found, __ATOMIC_RELAXED);
  }
  return found;
}

using PpollFunction = int(struct pollfd*, nfds_t, const struct timespec*, const sigset_t*);

PpollFunction* native_ppoll() {
  static PpollFunction* cache = nullptr;
  return next(cache, "ppoll");
}

int poll_in_rig_time(gpio::State& state, struct pollfd* polled, nfds_t count, const struct timespec* timeout,
                     const sigset_t* signals) {
  if (!gpio::is_loop()) gpio::become_loop(state);
  const std::int64_t duration = timeout == nullptr ? -1 : timeout->tv_sec * 1'000'000'000 + timeout->tv_nsec;
  const auto native = [&](std::int64_t timeout_ns) {
    const struct timespec at_most = timespec_of(timeout_ns);
    return native_ppoll()(polled, count, &at_most, signals);
  };
  if (duration != 0) return gpio::sleep_loop(state, duration, native);
  gpio::now_ns(state);
  return native(0);
}

}  // namespace

STROBE_EXPORT int clock_gettime(clockid_t clock, struct timespec* time) noexcept {
  gpio::State* state = kept();
  if (state == nullptr || (clock != CLOCK_MONOTONIC && clock != CLOCK_REALTIME && clock != CLOCK_BOOTTIME))
    return gpio::sys::clock_gettime(clock, time);
  if (clock == CLOCK_MONOTONIC) {
    *time = timespec_of(gpio::now_ns(*state));
    return 0;
  }
  // All clocks go and stand together. Read before the lag: a preemption in between must not look like a sleep.
  const int result = gpio::sys::clock_gettime(clock, time);
  const std::int64_t there = time->tv_sec * 1'000'000'000 + time->tv_nsec;
  *time = timespec_of(there - gpio::lag_ns(*state));
  return result;
}

STROBE_EXPORT int pthread_setschedparam(pthread_t thread, int policy,
                                        const struct sched_param* wanted) noexcept {
  using Function = int(pthread_t, int, const struct sched_param*);
  static Function* cache = nullptr;
  // Whether it is granted or not: a machine may lack the right, rig time stands in for it.
  if (pthread_equal(thread, pthread_self()) != 0)
    asked_for_real_time = (policy & ~SCHED_RESET_ON_FORK) == SCHED_FIFO;
  return next(cache, "pthread_setschedparam")(thread, policy, wanted);
}

STROBE_EXPORT int ppoll(struct pollfd* polled, nfds_t count, const struct timespec* timeout,
                        const sigset_t* signals) {
  gpio::State* state = asked_for_real_time ? kept() : nullptr;
  return state == nullptr ? native_ppoll()(polled, count, timeout, signals)
                          : poll_in_rig_time(*state, polled, count, timeout, signals);
}
// What ppoll() becomes under _FORTIFY_SOURCE.
STROBE_EXPORT int __ppoll_chk(struct pollfd* polled, nfds_t count, const struct timespec* timeout,
                              const sigset_t* signals, size_t) {
  return ppoll(polled, count, timeout, signals);
}
