#include "tests/benchmarks/timing/freeze_detector.hpp"

#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <utility>

#include "tests/benchmarks/timing/clock.hpp"

namespace strobe::benchmarks::timing {

static_assert(FreezeDetector::kPeriod == CoreInterrupts::kPeriod);

namespace {

constexpr Duration kCollected = milliseconds(500);

void sleep_until(MonoTime deadline) {
  const timespec t{to_ns(deadline) / 1'000'000'000, to_ns(deadline) % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {
  }
}

void stay_on(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(cpu), &set);
  pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

MonoTime next_whole(Duration period) { return MonoTime{(now().time_since_epoch() / period + 1) * period}; }

}  // namespace

std::vector<Freeze> stops_of(std::span<const CoreInterrupt> interrupts, int cpu) {
  std::vector<Freeze> stops;
  for (std::size_t i = 1; i < interrupts.size(); ++i) {
    const MonoTime before = interrupts[i - 1].at;
    if (interrupts[i].at - before > FreezeDetector::kPeriod + FreezeDetector::kLateInterrupt)
      stops.push_back({before, interrupts[i].at, cpu});
  }
  return stops;
}

FreezeDetector::FreezeDetector(int priority, Method wanted)
    : seen_(std::max(1U, std::thread::hardware_concurrency())) {
  if (wanted == Method::interrupts && open_interrupts(seen_.size())) {
    threads_.emplace_back([this] { collect(); });
    for (std::size_t cpu = 0; cpu < seen_.size(); ++cpu)
      threads_.emplace_back([this, cpu] { keep_ticking(static_cast<int>(cpu)); });
    return;
  }
  for (std::size_t cpu = 0; cpu < seen_.size(); ++cpu)
    threads_.emplace_back([this, cpu, priority] { watch(static_cast<int>(cpu), priority, seen_[cpu]); });
}

FreezeDetector::~FreezeDetector() {
  running_ = false;
  for (std::thread& thread : threads_)
    if (thread.joinable()) thread.join();
}

bool FreezeDetector::open_interrupts(std::size_t cores) {
  for (std::size_t cpu = 0; cpu < cores; ++cpu) {
    auto interrupts = CoreInterrupts::open(static_cast<int>(cpu));
    if (!interrupts) {
      interrupts_.clear();
      return false;
    }
    interrupts_.push_back(std::move(*interrupts));
  }
  taken_.resize(cores);
  return true;
}

void FreezeDetector::collect() {
  try {
    for (bool last = false; !last;) {
      last = !running_;
      for (std::size_t cpu = 0; cpu < interrupts_.size(); ++cpu) interrupts_[cpu].take(taken_[cpu]);
      if (!last) sleep_until(next_whole(kCollected));
    }
  } catch (const std::exception& error) {
    fault_ = error.what();
  }
}

void FreezeDetector::keep_ticking(int cpu) {
  stay_on(cpu);
  const sched_param param{};
  pthread_setschedparam(pthread_self(), SCHED_IDLE, &param);
  while (running_.load(std::memory_order_relaxed)) {
  }
}

void FreezeDetector::watch(int cpu, int priority, std::vector<Freeze>& seen) {
  stay_on(cpu);
  const sched_param param{.sched_priority = priority};
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  while (running_.load(std::memory_order_relaxed)) {
    const MonoTime deadline = next_whole(kPeriod);
    sleep_until(deadline);
    const MonoTime woken = now();
    if (woken - deadline > kLateWakeUp) seen.push_back({deadline - kPeriod, woken, cpu});
  }
}

std::vector<Freeze> FreezeDetector::stop() {
  running_ = false;
  for (std::thread& thread : threads_)
    if (thread.joinable()) thread.join();
  if (!fault_.empty()) throw std::runtime_error(fault_);
  for (std::size_t cpu = 0; cpu < taken_.size(); ++cpu)
    seen_[cpu] = stops_of(taken_[cpu], static_cast<int>(cpu));
  std::vector<Freeze> all;
  for (const auto& seen : seen_) all.insert(all.end(), seen.begin(), seen.end());
  std::sort(all.begin(), all.end(), [](const Freeze& a, const Freeze& b) { return a.begin < b.begin; });
  return all;
}

std::string freezes_in_words(const std::vector<Freeze>& freezes, FreezeDetector::Method by) {
  Duration sum{};
  Duration longest{};
  for (const Freeze& freeze : freezes) {
    sum = sum + (freeze.end - freeze.begin);
    longest = std::max(longest, freeze.end - freeze.begin);
  }
  return std::to_string(freezes.size()) +
         (by == FreezeDetector::Method::interrupts ? " stops of a core, "
                                                   : " stops of a core or late wake-ups on it, ") +
         std::to_string(sum / milliseconds(1)) + " ms in all, longest " +
         std::to_string(longest / milliseconds(1)) + " ms";
}

bool stands_still_often(const std::vector<Freeze>& freezes, Duration watched) {
  Duration sum{};
  for (const Freeze& freeze : freezes) sum = sum + (freeze.end - freeze.begin);
  return sum * 100 >= watched * static_cast<std::int64_t>(std::thread::hardware_concurrency());
}

bool within_freeze(const std::vector<Freeze>& freezes, MonoTime from, MonoTime to, int cpu) {
  return std::any_of(freezes.begin(), freezes.end(), [&](const Freeze& freeze) {
    return (cpu < 0 || cpu == freeze.cpu) && freeze.begin <= to && from <= freeze.end;
  });
}

}  // namespace strobe::benchmarks::timing
