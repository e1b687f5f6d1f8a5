#include "host/clock/clock_reading.hpp"

#include <cstdlib>
#include <utility>

namespace strobe::host {
namespace {

constexpr std::int64_t kApart_ns = 50'000'000;
constexpr std::int64_t kSlewedShare = 2000;  // 500 ppm, the most that a kernel's clock discipline slews

}  // namespace

std::optional<ClockStepDetector::Change> ClockStepDetector::on_reading(const ClockReading& now) {
  if (!last_) {
    last_ = now;
    return std::nullopt;
  }
  const ClockReading before = *std::exchange(last_, now);
  const std::int64_t passed_ns = now.boot_time_ns - before.boot_time_ns;
  const std::int64_t suspended_ns = passed_ns - (now.mono_ns - before.mono_ns);
  const std::int64_t stepped_ns = now.wall_ns - before.wall_ns - passed_ns;
  const std::int64_t allowed_ns = kApart_ns + std::abs(passed_ns) / kSlewedShare;
  Change change;
  if (suspended_ns > kApart_ns) change.suspended_ns = suspended_ns;
  if (std::abs(stepped_ns) > allowed_ns) change.stepped_ns = stepped_ns;
  if (change.suspended_ns == 0 && change.stepped_ns == 0) return std::nullopt;
  return change;
}

}  // namespace strobe::host
