#include "sim/gpiochip/rig_time.hpp"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <iterator>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/ownership.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

// What a real-time thread is charged. On an idle machine a look at the clock costs 17 to 50 ns, a poll of the
// inputs about 2 us.
constexpr std::int64_t kLook = 50;
constexpr std::int64_t kPoll = 2'000;
// Other threads look at the clock for nothing, but one that does so over and over waits for it.
constexpr int kLooksOfOneWhoWaits = 1'000;
constexpr std::int64_t kImpatientWait = 20'000;

constexpr std::int64_t kKeeperLooksAfter = 1'000'000'000;  // a wait is looked after each second
constexpr int kKeeperIsGone = 20;                          // seconds without a beat

/// The rig whose time this process lives in. Others that look at its clock are no part of it.
std::atomic<const State*> joined{nullptr};
bool takes_part(const State& state) { return joined.load(std::memory_order_relaxed) == &state; }

/// The thread's own part.
struct Thread {
  TimedWait* wait = nullptr;
  bool real_time = false;
  bool is_loop = false;
  int looks = 0;  ///< since it waited
  std::uint64_t draws = 0;
  std::uint32_t polled_turn = 0;  ///< of the rig at the last poll that found nothing
  int writes = 0;
  struct {
    int fd;
    std::uint64_t value;
  } put_off[8];

  ~Thread();
};
thread_local Thread self;

void write_now() {
  for (int i = 0; i < self.writes; ++i)
    sys::write(self.put_off[i].fd, &self.put_off[i].value, sizeof(std::uint64_t));
  self.writes = 0;
}

std::int32_t thread_id() { return static_cast<std::int32_t>(::syscall(SYS_gettid)); }

void give_back(TimedWait*& wait) {
  if (wait != nullptr && wait->tid.load() == thread_id()) {  // a forked child has its parent's
    wait->until_ns.store(kNever);
    wait->tid.store(0);
  }
  wait = nullptr;
}

Thread::~Thread() {
  write_now();
  give_back(wait);
}

bool is_of(const RigTime& time, const TimedWait* wait) {
  return wait >= std::begin(time.waits) && wait < std::end(time.waits);
}

TimedWait& own_wait(RigTime& time) {
  if (!is_of(time, self.wait)) give_back(self.wait);  // of another rig
  if (self.wait != nullptr && self.wait->tid.load() == thread_id()) return *self.wait;
  for (TimedWait& wait : time.waits) {
    std::int32_t free = 0;
    if (!wait.tid.compare_exchange_strong(free, thread_id())) continue;
    wait.until_ns.store(kNever);
    wait.pid.store(::getpid());
    self.wait = &wait;
    return wait;
  }
  ::abort();  // more threads than a rig has
}

void lower(std::atomic<std::int64_t>& least, std::int64_t value) {
  std::int64_t before = least.load();
  while (value < before && !least.compare_exchange_weak(before, value)) {
  }
}

/// Time never goes back. While the loop runs nobody else sets it: without a locked instruction, which would
/// be half of what a look costs.
std::int64_t raise(std::atomic<std::int64_t>& latest, std::int64_t value) {
  std::int64_t before = latest.load();
  if (self.is_loop) {
    if (before < value) latest.store(value, std::memory_order_release);
    return std::max(before, value);
  }
  while (before < value && !latest.compare_exchange_weak(before, value)) {
  }
  return std::max(before, value);
}

/// Nobody keeps the time any more, and nobody said so: the rig was killed.
void stop_if_keeper_is_gone(RigTime& time, std::uint32_t& beat, int& seconds) {
  const std::uint32_t now = time.beats.load();
  seconds = now == beat ? seconds + 1 : 0;
  beat = now;
  if (seconds < kKeeperIsGone) return;
  time.ahead_ns.store(time.now_ns.load() - sys::now_ns());
  time.pace.store(Pace::machine);
}

/// Until the keeper wakes it, all others being asleep; then it is `until_ns`.
void hold(State& state, std::int64_t until_ns) {
  RigTime& time = state.time;
  TimedWait& wait = own_wait(time);
  const std::uint32_t woken = wait.woken.load();
  write_now();
  begin_wait(state, until_ns, WakeBy::word);
  std::uint32_t beat = time.beats.load();
  int seconds = 0;
  while (wait.woken.load() == woken && is_kept(state)) {
    sys::futex_wait(&wait.woken, woken, sys::now_ns() + kKeeperLooksAfter);
    if (wait.woken.load() == woken) stop_if_keeper_is_gone(time, beat, seconds);
  }
  end_wait();
}

bool rig_sleeps(State& state) {
  return state.time.seen.load() >= newest(state) && state.time.now_ns.load() < state.time.rig_ns.load();
}

/// The rig does what is due, or looks at a change.
void let_rig_turn(State& state) {
  RigTime& time = state.time;
  std::uint32_t beat = time.beats.load();
  int seconds = 0;
  while (!rig_sleeps(state) && is_kept(state)) {
    const std::uint32_t turn = time.turns.load();
    wake_waiting(state);
    if (rig_sleeps(state)) return;
    sys::futex_wait(&time.turns, turn, sys::now_ns() + kKeeperLooksAfter);
    if (time.turns.load() == turn) stop_if_keeper_is_gone(time, beat, seconds);
  }
}

std::int64_t step(State& state, std::int64_t charge_ns) {
  RigTime& time = state.time;
  if (self.is_loop)  // nobody else counts
    time.loop_looks.store(time.loop_looks.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  const std::int64_t before = time.now_ns.load();
  std::int64_t target = before + charge_ns;
  if (time.pace.load() == Pace::wall) target = std::min(target, std::max(before, sys::now_ns()));
  for (;;) {
    if (self.is_loop && time.turns.load() != 0 && !rig_sleeps(state)) let_rig_turn(state);
    const std::int64_t rig = self.is_loop ? time.rig_ns.load() : kNever;
    const std::int64_t others = time.next_ns.load();
    if (!is_kept(state)) return now_ns(state);
    if (target < std::min(rig, others)) return raise(time.now_ns, target);
    if (rig <= others) {
      raise(time.now_ns, rig);
    } else {
      hold(state, target);
      return raise(time.now_ns, target);
    }
  }
}

/// 10 to 70 us, half of them below 18: as seen on an idle machine.
std::int64_t wake_up_latency() {
  std::uint64_t z = ++self.draws * 0x9e3779b97f4a7c15ULL;  // splitmix64
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  const double u = static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  return 10'000 + static_cast<std::int64_t>(60'000.0 * u * u * u);
}

int look_at(struct pollfd* polled, nfds_t count) {
  const struct timespec at_once {};
  return sys::ppoll(polled, count, &at_once, nullptr);
}

/// The signals that are held back, or would be by `signals`, without the one that ends waits.
sigset_t open_to_wake(const sigset_t* signals) {
  sigset_t open;
  if (signals != nullptr) {
    open = *signals;
  } else {
    pthread_sigmask(SIG_BLOCK, nullptr, &open);
  }
  sigdelset(&open, kWaitSignal);
  return open;
}

thread_local volatile sig_atomic_t signalled = 0;

/// Without a limit, but for looks at whether there still is a keeper. 0: until_ns has come.
int wait_natively(State& state, struct pollfd* polled, nfds_t count, std::int64_t until_ns,
                  const sigset_t* signals) {
  RigTime& time = state.time;
  const sigset_t open = open_to_wake(signals);
  std::uint32_t beat = time.beats.load();
  int seconds = 0;
  for (;;) {
    if (!is_kept(state)) {
      const struct timespec left =
          sys::to_timespec(std::clamp<std::int64_t>(until_ns - now_ns(state), 0, INT64_C(1'000'000'000'000)));
      return sys::ppoll(polled, count, &left, &open);
    }
    if (time.now_ns.load() >= until_ns) return look_at(polled, count);
    const struct timespec slice = sys::to_timespec(kKeeperLooksAfter);
    signalled = 0;
    const int ready = sys::ppoll(polled, count, &slice, &open);
    if (ready > 0 || (ready < 0 && (ready != -EINTR || signalled == 0))) return ready;
    if (ready == 0) stop_if_keeper_is_gone(time, beat, seconds);
  }
}

int answer(int result) {
  if (result >= 0) return result;
  errno = -result;
  return -1;
}

int poll_at_once(State& state, struct pollfd* polled, nfds_t count) {
  if (!self.is_loop) return answer(look_at(polled, count));
  step(state, kPoll);
  // Nobody has run since the last look.
  const std::uint32_t turn = state.time.turns.load() + (self.wait != nullptr ? self.wait->woken.load() : 0);
  if (turn == self.polled_turn) {
    for (nfds_t i = 0; i < count; ++i) polled[i].revents = 0;
    return 0;
  }
  const int ready = look_at(polled, count);
  self.polled_turn = ready == 0 ? turn : turn - 1;
  return answer(ready);
}

}  // namespace

std::int64_t now_ns(State& state) {
  if (!is_kept(state)) return sys::now_ns() + state.time.ahead_ns.load();
  if (self.is_loop) return step(state, kLook);
  if (!takes_part(state) || ++self.looks <= kLooksOfOneWhoWaits) return state.time.now_ns.load();
  if (self.real_time) return step(state, kLook);
  hold(state, state.time.now_ns.load() + kImpatientWait);
  return state.time.now_ns.load();
}

std::int64_t realtime_ns(State& state) {
  const std::int64_t less = state.time.realtime_less_ns.load();
  return less == 0 ? sys::clock_ns(CLOCK_REALTIME) : now_ns(state) + less;
}

std::int64_t boottime_ns(State& state) {
  const bool never_kept = state.time.realtime_less_ns.load() == 0;
  return never_kept ? sys::clock_ns(CLOCK_BOOTTIME) : now_ns(state) + state.time.boottime_less_ns.load();
}

void join_time(State& state, std::int32_t pid) {
  if (pid == ::getpid()) joined.store(&state);
  state.time.begun.store(1);
  for (std::atomic<std::int32_t>& program : state.time.programs)
    if (program.load() == pid) return;
  for (std::atomic<std::int32_t>& program : state.time.programs) {
    std::int32_t free = 0;
    if (program.compare_exchange_strong(free, pid)) return;
  }
}

void prepare_waits() {
  struct sigaction action {};
  action.sa_handler = [](int) { signalled = 1; };
  sigaction(kWaitSignal, &action, nullptr);
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, kWaitSignal);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

void begin_wait(State& state, std::int64_t until_ns, WakeBy wake_by) {
  self.looks = 0;
  RigTime& time = state.time;
  TimedWait& wait = own_wait(time);
  wait.wake_by.store(wake_by);
  wait.until_ns.store(until_ns);
  if (!self.is_loop && wake_by != WakeBy::ring) lower(time.next_ns, until_ns);
  if (!self.is_loop) return;
  time.asleep.fetch_add(1);
  sys::futex_wake_all(&time.asleep);
}

void end_wait() {
  if (self.wait != nullptr) self.wait->until_ns.store(kNever);
}

int wait_for(State& state, struct pollfd* polled, nfds_t count, std::int64_t timeout_ns,
             const sigset_t* signals) {
  if (timeout_ns == 0) return poll_at_once(state, polled, count);
  const std::int64_t begin = now_ns(state);
  std::int64_t until = timeout_ns < 0 || timeout_ns > kNever / 2 ? kNever : begin + timeout_ns;
  if (self.is_loop && until != kNever) until += wake_up_latency();
  write_now();
  begin_wait(state, until, WakeBy::signal);
  int ready = wait_natively(state, polled, count, until, signals);
  end_wait();
  if (self.is_loop) self.polled_turn = state.time.turns.load() - 1;
  if (ready > 0 && is_kept(state)) {
    // Whoever woke it first comes to an end.
    hold(state, state.time.now_ns.load() + (self.is_loop ? wake_up_latency() : 0));
    ready = look_at(polled, count);
  }
  return answer(ready);
}

void wait_for_turn(State& state) {
  if (takes_part(state)) hold(state, state.time.now_ns.load());
}

void leave(State& state) {
  if (is_of(state.time, self.wait)) give_back(self.wait);
}

void note_real_time(bool real_time) { self.real_time = real_time; }

void become_loop(State& state) {
  if (self.is_loop || !self.real_time) return;
  self.is_loop = true;
  state.time.loop_pid.store(::getpid());
  state.time.loop_tid.store(thread_id());
  hold(state, state.time.now_ns.load());  // until all that began with it sleep
}

bool is_loop() { return self.is_loop; }

bool put_off_write(int fd, std::uint64_t value) {
  if (!self.is_loop) return false;
  for (int i = 0; i < self.writes; ++i) {
    if (self.put_off[i].fd != fd) continue;
    self.put_off[i].value += value;
    return true;
  }
  if (self.writes == static_cast<int>(sizeof(self.put_off) / sizeof(self.put_off[0]))) return false;
  self.put_off[self.writes++] = {fd, value};
  return true;
}

bool is_terminal(const State& state, int fd) {
  const std::uint64_t inode = state.time.terminal_inode.load();
  sys::FileId id;
  return inode != 0 && sys::identify(fd, id) == 0 && id.inode == inode &&
         id.device == state.time.terminal_device.load();
}

long write_to_terminal(State& state, const char* folder, const void* data, std::size_t size) {
  char path[kPathSize];
  if (!path_in(folder, kTerminalFile, path)) return -ENAMETOOLONG;
  const int fifo = sys::open(path, O_WRONLY | O_NONBLOCK | O_CLOEXEC);
  if (fifo < 0) return -EIO;  // hung up
  RigTime& time = state.time;
  const TerminalWrite head{is_kept(state) ? time.now_ns.load() : now_ns(state),
                           std::min(size, TerminalWrite::kMaxSize)};
  char record[sizeof head + TerminalWrite::kMaxSize];
  memcpy(record, &head, sizeof head);
  memcpy(record + sizeof head, data, head.size);
  time.terminal_written.fetch_add(head.size);                              // before it is on its way
  const long written = sys::write(fifo, record, sizeof head + head.size);  // all of it, or nothing
  if (written < 0) time.terminal_written.fetch_sub(head.size);
  sys::close(fifo);
  return written < 0 ? written : static_cast<long>(head.size);
}

void sleep_as_rig(State& state, std::uint64_t ring_position, std::uint32_t wake, std::int64_t until_ns) {
  RigTime& time = state.time;
  begin_wait(state, until_ns, WakeBy::ring);
  time.rig_ns.store(until_ns);
  time.seen.store(ring_position);
  time.turns.fetch_add(1);
  sys::futex_wake_all(&time.turns);
  sys::futex_wait(&state.wake, wake, sys::now_ns() + kKeeperLooksAfter);
  end_wait();
}

}  // namespace strobe::sim::gpio
