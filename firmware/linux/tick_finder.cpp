#include "firmware/linux/tick_finder.hpp"

#include <algorithm>
#include <ctime>
#include <thread>
#include <vector>

#include "firmware/linux/real_time.hpp"
#include "firmware/linux/system_clock.hpp"

namespace strobe::firmware {

namespace {

constexpr Duration kShortest = microseconds(1);
constexpr std::size_t kMaxGaps = 4096;

std::vector<Gap> gaps_of_spin(Duration length) {
  SystemClock clock;
  std::vector<Gap> gaps;
  gaps.reserve(kMaxGaps);
  MonoTime last = clock.now();
  const MonoTime end = last + length;
  while (last < end && gaps.size() < kMaxGaps) {
    const MonoTime now = clock.now();
    if (now - last > kShortest) gaps.push_back({last, now - last});
    last = now;
  }
  return gaps;
}

}  // namespace

Tick find_tick(const Rig::RealTime& wanted) {
  timespec resolution{};
  if (clock_getres(CLOCK_MONOTONIC_COARSE, &resolution) != 0) return {};
  // The coarse clock is set at every tick: its resolution is the tick's period.
  const Duration period = nanoseconds(resolution.tv_sec * 1'000'000'000 + resolution.tv_nsec);
  if (period < microseconds(100) || period > milliseconds(50)) return {};
  const int periods = static_cast<int>(std::clamp<std::int64_t>(milliseconds(60) / period, 8, 25));
  Tick tick;
  std::thread([&] {
    pin_to_cpu(wanted.cpu);
    become_real_time(wanted.priority);
    tick = detect_tick(gaps_of_spin(period * periods), period, periods);
  }).join();
  return tick;
}

}  // namespace strobe::firmware
