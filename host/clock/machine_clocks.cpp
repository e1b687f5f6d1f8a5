#include "host/clock/machine_clocks.hpp"

#include <cstdlib>
#include <utility>

namespace strobe::host {
namespace {

constexpr std::int64_t kApart_ns = 50'000'000;
constexpr std::int64_t kSlewedShare = 2000;  // 500 ppm, the most that a kernel's clock discipline slews

}  // namespace

std::optional<ClockWatch::Change> ClockWatch::on_reading(const MachineClocks& now) {
  if (!last_) {
    last_ = now;
    return std::nullopt;
  }
  const MachineClocks before = *std::exchange(last_, now);
  const std::int64_t passed_ns = now.boot_time_ns - before.boot_time_ns;
  const std::int64_t slept_ns = passed_ns - (now.mono_ns - before.mono_ns);
  const std::int64_t stepped_ns = now.wall_ns - before.wall_ns - passed_ns;
  const std::int64_t allowed_ns = kApart_ns + std::abs(passed_ns) / kSlewedShare;
  Change change;
  if (slept_ns > kApart_ns) change.slept_ns = slept_ns;
  if (std::abs(stepped_ns) > allowed_ns) change.stepped_ns = stepped_ns;
  if (change.slept_ns == 0 && change.stepped_ns == 0) return std::nullopt;
  return change;
}

}  // namespace strobe::host
