#include "tests/bench/timing/witness.hpp"

#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <algorithm>

#include "tests/bench/timing/clock.hpp"

namespace strobe::bench::timing {

namespace {

void sleep_until(MonoTime deadline) {
  const timespec t{deadline.ns / 1'000'000'000, deadline.ns % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {
  }
}

}  // namespace

Witness::Witness(int priority) : seen_(std::max(1U, std::thread::hardware_concurrency())) {
  for (std::size_t cpu = 0; cpu < seen_.size(); ++cpu) {
    threads_.emplace_back([this, cpu, priority] { watch(static_cast<int>(cpu), priority, seen_[cpu]); });
  }
}

Witness::~Witness() { stop(); }

void Witness::watch(int cpu, int priority, std::vector<Freeze>& seen) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(cpu), &set);
  pthread_setaffinity_np(pthread_self(), sizeof set, &set);
  const sched_param param{.sched_priority = priority};
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  while (running_.load(std::memory_order_relaxed)) {
    const MonoTime deadline{(now().ns / kPeriod.ns + 1) * kPeriod.ns};
    sleep_until(deadline);
    const MonoTime woken = now();
    if (woken - deadline > kThreshold) seen.push_back({deadline - kPeriod, woken});
  }
}

std::vector<Freeze> Witness::stop() {
  running_ = false;
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
  std::vector<Freeze> all;
  for (const auto& seen : seen_) all.insert(all.end(), seen.begin(), seen.end());
  std::sort(all.begin(), all.end(), [](const Freeze& a, const Freeze& b) { return a.begin < b.begin; });
  return all;
}

bool within_freeze(const std::vector<Freeze>& freezes, MonoTime from, MonoTime to) {
  return std::any_of(freezes.begin(), freezes.end(),
                     [&](const Freeze& freeze) { return freeze.begin <= to && from <= freeze.end; });
}

}  // namespace strobe::bench::timing
