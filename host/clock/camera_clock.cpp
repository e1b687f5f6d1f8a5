#include "host/clock/camera_clock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace strobe::host {
namespace {

constexpr Duration kKeptFor = std::chrono::seconds{30};
constexpr std::size_t kMaxExchanges = 48;
// What a crystal's rate may change within seconds, by its warming: bounds widen with their age.
constexpr double kWander_ns_per_s = 100.0;
// No two clocks differ by more, 1000 ppm.
constexpr double kMaxDrift_ns_per_s = 1e6;
// What reading a clock takes, and rounding.
constexpr double kReading_ns = 100.0;

}  // namespace

/// The highest that a line between all bounds can be at an instant. In this linear program of two unknowns
/// two constraints are active: a bound and the largest drift, or two bounds.
double CameraClock::highest_ns(double at_s) const {
  double highest_ns = std::numeric_limits<double>::infinity();
  for (const Bounds& upper : bounds_) {
    const double ahead_s = at_s - upper.at_s;
    const double high_ns = upper.high_ns + kWander_ns_per_s * std::abs(ahead_s);
    highest_ns = std::min(highest_ns, high_ns + kMaxDrift_ns_per_s * std::abs(ahead_s));
    for (const Bounds& other : bounds_) {
      const double apart_s = upper.at_s - other.at_s;
      if (apart_s == 0.0) continue;
      const double wander_ns = kWander_ns_per_s * std::abs(at_s - other.at_s);
      // Turned about this bound by the other, which is beyond it (from below) or on the other side.
      const bool beyond = (apart_s > 0.0) == (ahead_s > 0.0);
      const bool between = !beyond && std::abs(ahead_s) < std::abs(apart_s);
      if (!beyond && !between) continue;
      const double other_ns = beyond ? other.low_ns - wander_ns : other.high_ns + wander_ns;
      highest_ns = std::min(highest_ns, high_ns + (high_ns - other_ns) / apart_s * ahead_s);
    }
  }
  return highest_ns;
}

double CameraClock::lowest_ns(double at_s) const {
  CameraClock mirrored(resolution_);
  for (const Bounds& bounds : bounds_)
    mirrored.bounds_.push_back({bounds.at_s, -bounds.high_ns, -bounds.low_ns, bounds.heard});
  return -mirrored.highest_ns(at_s);
}

bool CameraClock::possible() const {
  return std::ranges::all_of(
      bounds_, [this](const Bounds& bounds) { return lowest_ns(bounds.at_s) <= highest_ns(bounds.at_s); });
}

void CameraClock::on_exchange(const ClockExchange& exchange) {
  if (bounds_.empty()) {
    origin_camera_ns_ = exchange.camera_ns;
    origin_offset_ = exchange.before.time_since_epoch() - Duration{exchange.camera_ns};
  }
  const auto offset_ns = [&](HostTime host) {
    return static_cast<double>(
        (host.time_since_epoch() - Duration{exchange.camera_ns} - origin_offset_).count());
  };
  const double at_s = to_seconds(Duration{exchange.camera_ns - origin_camera_ns_});
  const auto resolution_ns = static_cast<double>(resolution_.count());
  bounds_.push_back({at_s, offset_ns(exchange.before) - resolution_ns - kReading_ns,
                     offset_ns(exchange.after) + kReading_ns, exchange.after});
  while (bounds_.size() > kMaxExchanges || exchange.after - bounds_.front().heard > kKeptFor)
    bounds_.pop_front();
  const std::size_t kept = bounds_.size();
  while (!possible()) bounds_.pop_front();
  if (kept == 1 || bounds_.size() != 1) return;
  ++restarts_;
  bounds_.clear();
  on_exchange(exchange);
}

std::optional<CameraInstant> CameraClock::local(std::int64_t camera_ns) const {
  if (bounds_.empty()) return std::nullopt;
  const double at_s = to_seconds(Duration{camera_ns - origin_camera_ns_});
  const double lowest = lowest_ns(at_s), highest = highest_ns(at_s);
  const auto resolution_ns = static_cast<double>(resolution_.count());
  const double sd_ns = std::hypot(highest - lowest, resolution_ns) / std::sqrt(12.0);
  const auto offset = origin_offset_ + Duration{std::llround((lowest + highest + resolution_ns) / 2.0)};
  return CameraInstant{HostTime{Duration{camera_ns} + offset}, Duration{std::llround(std::ceil(sd_ns))}};
}

}  // namespace strobe::host
