#include "firmware/linux/machine_trial.hpp"

#include <poll.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "firmware/core/cpu_budget.hpp"
#include "firmware/linux/real_time.hpp"
#include "firmware/linux/system_clock.hpp"

namespace strobe::firmware {

namespace {

int flashes_of_shot(const Rig& rig) {
  const auto fit = length_of_shot(rig) / rig.lamps.min_period + 1;
  return static_cast<int>(std::clamp<std::int64_t>(fit, 2, rig.lamps.max_flashes));
}

/// Waits for flashes as the loop does.
class LoopLikeWait {
 public:
  LoopLikeWait(const Rig& rig, Clock& clock, const std::function<void(MonoTime)>& sleep)
      : spin_(rig.tolerance.spin),
        clock_(clock),
        sleep_(sleep),
        budget_(rig.tolerance),
        woken_(clock.now()) {}

  /// The instant at which it would be issued.
  MonoTime until(MonoTime due) {
    const MonoTime begin = clock_.now();
    budget_.note(begin, begin - woken_);
    woken_ = begin;
    if (const MonoTime wake = budget_.wake_time(due); wake > begin) {
      sleep_(wake);
      woken_ = clock_.now();
      budget_.note(woken_, {});
    }
    while (clock_.now() < due - spin_) sleep_(due - spin_ - kLongestSpell);
    return clock_.spin_until(due);
  }

 private:
  static constexpr Duration kLongestSpell = milliseconds(1000);  // long past: looks, but does not sleep
  Duration spin_;
  Clock& clock_;
  const std::function<void(MonoTime)>& sleep_;
  CpuBudget budget_;
  MonoTime woken_;
};

void sleep_in_kernel(MonoTime until) {
  const timespec timeout = time_left(until);
  ppoll(nullptr, 0, &timeout, nullptr);
}

}  // namespace

Duration length_of_shot(const Rig& rig) {
  const bool free = rig.plan.train == Train::free;
  const Duration planned = free ? rig.plan.exposure : train_length(rig.plan, rig.plan.flash_count);
  return std::max(rig.lamps.min_period, planned);
}

void play_trains(const Rig& rig, Clock& clock, const std::function<void(MonoTime)>& sleep, MonoTime end,
                 TrialTrace& trace) {
  const int flashes = flashes_of_shot(rig);
  const Duration rest = std::max<Duration>(milliseconds(20), length_of_shot(rig) / 4);
  LoopLikeWait wait(rig, clock, sleep);
  std::size_t count = 0;
  for (MonoTime first = clock.now() + rest; first < end && count < trace.flashes.size() && !trace.stop;) {
    MonoTime issued = first;
    for (int i = 0; i < flashes && count < trace.flashes.size() && !trace.stop; ++i) {
      const MonoTime due = first + rig.lamps.min_period * i;
      trace.due_ns = to_ns(due);
      issued = wait.until(due);
      trace.flashes[count] = {due, issued};
      trace.count = ++count;
      if (issued - due > rig.tolerance.abort_late) break;
    }
    trace.played = trace.played + (issued - first);
    first = issued + rest;
  }
}

MachineTrial try_machine(const Rig& rig, const std::set<int>& cpus, Duration length, const OpenWatch& open,
                         const std::function<void(Duration)>& progress) {
  MachineTrial trial;
  TrialTrace trace(static_cast<std::size_t>(length / rig.lamps.min_period) + 1);
  std::atomic<pid_t> tid = 0;
  std::atomic<bool> go = false, ended = false;
  const std::string memory = lock_memory();
  const LatencyRequest latency;
  SystemClock clock;
  std::thread player([&] {
    tid = static_cast<pid_t>(syscall(SYS_gettid));
    prefault_stack();
    const std::string pinned = pin_to_cpu(rig.real_time.cpu);
    const std::string fifo = become_real_time(rig.real_time.priority);
    trial.not_granted = !fifo.empty() ? fifo : !pinned.empty() ? pinned : memory;
    while (!go) sleep_in_kernel(clock.now() + milliseconds(1));
    SystemClock own;
    play_trains(rig, own, sleep_in_kernel, own.now() + length, trace);
    ended = true;
  });
  while (tid == 0) sleep_in_kernel(clock.now() + milliseconds(1));
  auto watch = open(cpus, tid);
  if (!watch) trial.not_named = watch.error().message;
  const MonoTime started = clock.now();
  trace.due_ns = to_ns(started);
  go = true;
  std::size_t seen = 0;
  for (bool last = false; !last;) {
    last = ended;
    for (const std::size_t count = trace.count; seen < count; ++seen) {
      const TrialFlash& flash = trace.flashes[seen];
      if (flash.lateness() <= rig.tolerance.late || trial.late.size() == MachineTrial::kMaxNamed) continue;
      trial.late.push_back({flash, watch ? (*watch)(flash.due, flash.issued) : Culprit{}});
    }
    if (!trial.starved && clock.now() - from_ns(trace.due_ns) > MachineTrial::kStarved) {
      trial.starved = true;
      trace.stop = true;
      allow_any_cpu(tid);
    }
    progress(clock.now() - started);
    if (!last) sleep_in_kernel(clock.now() + milliseconds(20));
  }
  player.join();
  munlockall();
  trace.flashes.resize(trace.count);
  trial.flashes = std::move(trace.flashes);
  trial.played = trace.played;
  return trial;
}

}  // namespace strobe::firmware
