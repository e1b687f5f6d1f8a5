#include "sim/gpiochip/rig_clock.hpp"

#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim {

MonoTime RigClock::now() const {
  return from_ns(state_ != nullptr ? gpio::now_ns(*state_) : gpio::sys::now_ns());
}

Duration RigClock::since_boot() const {
  return Duration{state_ != nullptr ? gpio::boottime_ns(*state_) : gpio::sys::clock_ns(CLOCK_BOOTTIME)};
}

WallTime RigClock::wall() const {
  return WallTime{
      Duration{state_ != nullptr ? gpio::realtime_ns(*state_) : gpio::sys::clock_ns(CLOCK_REALTIME)}};
}

void RigClock::sleep_for(Duration duration) const { static_cast<void>(poll(nullptr, 0, duration)); }

int RigClock::poll(struct pollfd* polled, nfds_t count, Duration timeout) const {
  const std::int64_t timeout_ns = to_ns(MonoTime{} + timeout);
  if (state_ != nullptr && gpio::is_kept(*state_)) return gpio::wait_for(*state_, polled, count, timeout_ns);
  return ::poll(polled, count, static_cast<int>(timeout_ns / 1'000'000));
}

std::uint64_t RigClock::seed() const { return state_ != nullptr ? state_->time.seed : 0; }

}  // namespace strobe::sim
