#include "host/clock/machine_clock.hpp"

#include <fmt/format.h>

#include <ctime>
#include <utility>

namespace strobe::host {
namespace {

constexpr Duration kApart = milliseconds{50};
constexpr int kSlewedShare = 2000;  // 500 ppm, the most that a kernel's clock discipline slews

Duration elapsed(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return std::chrono::seconds{time.tv_sec} + Duration{time.tv_nsec};
}

}  // namespace

HostTime steady_now() { return HostTime{elapsed(CLOCK_MONOTONIC)}; }

HostReading MachineClock::read() {
  return {steady_now(), WallTime{elapsed(CLOCK_REALTIME)}, elapsed(CLOCK_BOOTTIME)};
}

std::vector<std::string> describe(const ClockChange& change, const std::string& whose) {
  std::vector<std::string> lines;
  if (change.stepped != Duration{}) {
    lines.push_back(fmt::format("the wall clock of {} was set by {:+.1f} s; measured times are not affected",
                                whose, to_seconds(change.stepped)));
  }
  if (change.suspended != Duration{})
    lines.push_back(fmt::format("{} was suspended for {:.1f} s", whose, to_seconds(change.suspended)));
  return lines;
}

template <typename Time>
std::optional<ClockChange> ClockStepDetector<Time>::on_reading(const ClockReading<Time>& now) {
  const auto before = std::exchange(last_, now);
  if (!before) return std::nullopt;
  const Duration passed = now.since_boot - before->since_boot;
  const Duration suspended = passed - (now.mono - before->mono);
  const Duration stepped = now.wall - before->wall - passed;
  ClockChange change;
  if (suspended > kApart) change.suspended = suspended;
  if (abs(stepped) > kApart + abs(passed) / kSlewedShare) change.stepped = stepped;
  if (change.suspended == Duration{} && change.stepped == Duration{}) return std::nullopt;
  return change;
}

template class ClockStepDetector<MonoTime>;
template class ClockStepDetector<HostTime>;

}  // namespace strobe::host
