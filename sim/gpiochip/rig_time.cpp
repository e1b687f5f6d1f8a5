#include "sim/gpiochip/rig_time.hpp"

#include <stdio.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr std::int64_t kLookEvery = 10'000'000;
constexpr int kLooks = 10;  // a loop that waits for 100 ms without a call to us is not waited for
constexpr std::int64_t kLongestPoll = 10'000'000;  // after which an edge that is not the loop's is let go
constexpr std::int64_t kForRig = 200'000;  // the loop's wake-up has come, but the rig is not there yet
constexpr std::int64_t kRigIsGone = 20'000'000'000;  // it did not turn for so long

/// The loop's own clock, of its thread.
struct Loop {
  bool is_loop = false;
  std::int64_t own_ns = 0;   ///< rig time, never beyond the machine's
  std::int64_t wall_ns = 0;  ///< the machine's at the last look
  std::uint64_t draws = 0;
};
thread_local Loop loop;

std::int64_t not_before(RigTime& time, std::int64_t now) {
  std::int64_t latest = time.latest_ns.load();
  while (latest < now && !time.latest_ns.compare_exchange_weak(latest, now)) {
  }
  return std::max(latest, now);
}

std::int64_t shared_now_ns(RigTime& time) {
  // First: a limit that is taken away meanwhile must not let a later reading through.
  const std::int64_t wall = sys::now_ns();
  if (time.kept.load() == 0) return not_before(time, wall);
  return not_before(time, std::min({wall, time.loop_ns.load(), time.rig_ns.load(), time.edge_ns.load()}));
}

bool rig_is_there(State& state) {
  return state.time.kept.load() == 0 ||
         (state.time.seen.load() >= newest(state) && loop.own_ns < state.time.rig_ns.load());
}

void wait_for_rig(State& state) {
  RigTime& time = state.time;
  const std::int64_t give_up = sys::now_ns() + kRigIsGone;
  while (!rig_is_there(state)) {
    const std::uint32_t turn = time.turns.load();
    time.loop_ns.store(std::min(loop.own_ns, time.rig_ns.load()));
    if (rig_is_there(state)) break;
    state.waiting.store(1);
    notify(state);
    sys::futex_wait(&time.turns, turn, sys::now_ns() + 1'000'000);
    if (sys::now_ns() > give_up) time.kept.store(0);
  }
  loop.wall_ns = sys::now_ns();
}

std::int64_t step(State& state) {
  RigTime& time = state.time;
  const std::int64_t wall = sys::now_ns();
  if (time.loop_ns.load() == kNever)
    loop.own_ns = std::max(loop.own_ns, shared_now_ns(time));  // went on without it
  loop.own_ns += std::min(wall - loop.wall_ns, kLongestStep);
  loop.wall_ns = wall;
  if (!rig_is_there(state)) wait_for_rig(state);
  loop.own_ns = not_before(time, loop.own_ns);
  time.loop_ns.store(loop.own_ns);
  return loop.own_ns;
}

/// 10 to 70 us, half of them below 18.
std::int64_t wake_up_latency() {
  std::uint64_t z = ++loop.draws * 0x9e3779b97f4a7c15ULL;  // splitmix64
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  const double u = static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  return 10'000 + static_cast<std::int64_t>(60'000.0 * u * u * u);
}

/// A short file of /proc. False: there is none.
bool read_proc(int pid, int tid, const char* name, char (&text)[512]) {
  char path[64];
  snprintf(path, sizeof(path), "/proc/%d/task/%d/%s", pid, tid, name);
  const int fd = sys::open(path, 0);
  if (fd < 0) return false;
  const long size = sys::read(fd, text, sizeof(text) - 1);
  sys::close(fd);
  if (size <= 0) return false;
  text[size] = '\0';
  return true;
}

}  // namespace

std::int64_t now_ns(State& state) {
  if (loop.is_loop && state.time.kept.load() != 0) return step(state);
  return shared_now_ns(state.time);
}

std::int64_t lag_ns(State& state) {
  if (state.time.kept.load() == 0) return 0;
  const std::int64_t now = now_ns(state);
  return std::max<std::int64_t>(0, sys::now_ns() - now);
}

void keep_time(State& state, std::uint64_t ring_position) {
  RigTime& time = state.time;
  time.loop_ns.store(kNever);
  time.rig_ns.store(kNever);
  time.edge_ns.store(kNever);
  time.seen.store(ring_position);
  time.kept.store(1);
}

void stop_keeping_time(State& state) {
  state.time.kept.store(0);
  state.time.turns.fetch_add(1);
  sys::futex_wake_all(&state.time.turns);
}

void rig_turned(State& state, std::uint64_t ring_position, std::int64_t due_ns) {
  RigTime& time = state.time;
  time.rig_ns.store(due_ns);
  time.seen.store(ring_position);
  time.turns.fetch_add(1);
  sys::futex_wake_all(&time.turns);
}

void hold_for_edge(State& state, std::int64_t stamp_ns) {
  RigTime& time = state.time;
  if (time.kept.load() == 0 || time.loop_sleeps.load() == 0 || time.loop_ns.load() == kNever) return;
  std::int64_t none = kNever;
  time.edge_ns.compare_exchange_strong(none, stamp_ns);
}

void LoopWatch::look(State& state) {
  RigTime& time = state.time;
  const std::int64_t wall = sys::now_ns();
  const std::int64_t at = time.loop_ns.load();
  if (time.kept.load() == 0 || wall - looked_ns_ < kLookEvery) return;
  looked_ns_ = wall;
  const bool waited_for = at != kNever && (time.loop_sleeps.load() == 0 || at <= wall);
  if (!waited_for || at != at_ns_) {
    at_ns_ = at;
    stuck_ = 0;
    return;
  }
  char status[512];
  char times[512];
  const int pid = time.loop_pid.load();
  const int tid = time.loop_tid.load();
  const bool there = read_proc(pid, tid, "stat", status) && read_proc(pid, tid, "schedstat", times);
  unsigned long long ran = 0;
  const char* const name_end = there ? strrchr(status, ')') : nullptr;
  const bool runnable = name_end != nullptr && name_end[1] == ' ' && name_end[2] == 'R';
  if (there) sscanf(times, "%llu", &ran);
  const bool hangs = !runnable || ran - ran_ns_ > kLookEvery / 2;
  ran_ns_ = ran;
  stuck_ = hangs ? stuck_ + 1 : 0;
  if (there && stuck_ < kLooks) return;
  std::int64_t expected = at;
  if (time.loop_ns.compare_exchange_strong(expected, kNever)) time.edge_ns.store(kNever);
}

void become_loop(State& state) {
  RigTime& time = state.time;
  loop.is_loop = true;
  loop.own_ns = shared_now_ns(time);
  loop.wall_ns = sys::now_ns();
  time.loop_sleeps.store(0);
  time.loop_pid.store(::getpid());
  time.loop_tid.store(static_cast<int>(::syscall(SYS_gettid)));
  time.loop_ns.store(loop.own_ns);
}

bool is_loop() { return loop.is_loop; }

std::int64_t begin_sleep(State& state, std::int64_t duration_ns) {
  const std::int64_t now = step(state);
  const std::int64_t wake = duration_ns < 0 ? kNever - 1 : now + duration_ns + wake_up_latency();
  state.time.edge_ns.store(kNever);
  state.time.loop_sleeps.store(1);
  state.time.loop_ns.store(wake);
  return wake;
}

std::int64_t left_to_sleep(State& state, std::int64_t wake_ns) {
  if (shared_now_ns(state.time) >= wake_ns) return 0;
  const std::int64_t wall = sys::now_ns();
  return wall < wake_ns ? std::min(wake_ns - wall, kLongestPoll) : kForRig;
}

void end_sleep(State& state, bool by_event) {
  RigTime& time = state.time;
  const std::int64_t now = shared_now_ns(time);
  const std::int64_t wall = sys::now_ns();
  loop.own_ns = std::max(loop.own_ns, by_event ? std::min(now + wake_up_latency(), wall) : now);
  loop.wall_ns = wall;
  time.loop_ns.store(loop.own_ns);
  time.loop_sleeps.store(0);
  time.edge_ns.store(kNever);
}

}  // namespace strobe::sim::gpio
