// A simulated firmware's heartbeats: its clocks and this machine's are known, and every delay. Deterministic
// in its seed.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <random>

#include "host/clock/device_clock.hpp"

namespace strobe::host_test {

class Heartbeats {
 public:
  explicit Heartbeats(unsigned seed) : random_(seed) {}

  std::int64_t boot_id = 5;
  double drift = 0.0;  ///< this machine's clock against the device's
  std::int64_t local_offset_ns = 7'000'000'000;
  std::int64_t device_wall_ns = 1'700'000'000'000'000'000;  ///< less its CLOCK_BOOTTIME
  double lost_share = 0.0;
  double long_share = 0.0;   ///< messages with some milliseconds more
  double burst_share = 0.0;  ///< of messages that begin a burst of ten, 5 to 10 ms late
  double extra_delay_s = 0.0;
  double wander = 0.0;  ///< what the drift's random walk gains per square root of a second

  static constexpr double kDelay_s = 100e-6;  ///< that all messages have; usual ones vary by kJitter_s
  static constexpr double kJitter_s = 20e-6;

  struct Beat {
    host::ClockReading device;
    std::int64_t heard_ns = 0;
  };
  /// Half a second later: one more heartbeat, unless it is lost.
  std::optional<Beat> next() {
    device_s_ += 0.5;
    if (wander > 0.0) change_drift(std::normal_distribution<double>(drift, wander * std::sqrt(0.5))(random_));
    const double delay_s = draw_delay_s();
    if (uniform() < lost_share) return std::nullopt;
    return Beat{{device_ns(), device_wall_ns + device_ns() + slept_ns_, device_ns() + slept_ns_},
                local_ns() + static_cast<std::int64_t>(delay_s * 1e9)};
  }
  void send(host::DeviceClock& clock) {
    if (const auto beat = next()) clock.on_heartbeat(boot_id, beat->device, beat->heard_ns);
  }

  std::int64_t device_ns() const { return static_cast<std::int64_t>(device_s_ * 1e9); }
  /// This machine's clock at device_ns().
  std::int64_t local_ns() const {
    return local_offset_ns + device_ns() +
           static_cast<std::int64_t>(drift * (device_s_ - drift_from_s_) * 1e9);
  }
  double offset_s() const { return static_cast<double>(local_ns() - device_ns()) * 1e-9; }

  void change_drift(double to) {
    local_offset_ns = local_ns() - device_ns();
    drift_from_s_ = device_s_;
    drift = to;
  }
  void suspend(double seconds) {
    slept_ns_ += static_cast<std::int64_t>(seconds * 1e9);
    local_offset_ns += static_cast<std::int64_t>(seconds * 1e9);
  }
  void reboot() {
    local_offset_ns += device_ns() + 40'000'000'000;
    device_s_ = drift_from_s_ = 10.0;
    slept_ns_ = 0;
    boot_id = 99;
  }

 private:
  double uniform() { return std::uniform_real_distribution<double>()(random_); }
  double draw_delay_s() {
    double delay_s = extra_delay_s + std::normal_distribution<double>(kDelay_s, kJitter_s)(random_);
    if (uniform() < long_share) delay_s += std::exponential_distribution<double>(500.0)(random_);
    if (burst_left_ == 0 && uniform() < burst_share) burst_left_ = 10;
    if (burst_left_ > 0) {
      --burst_left_;
      delay_s += 0.005 * (1.0 + uniform());
    }
    return delay_s;
  }

  std::mt19937_64 random_;
  double device_s_ = 1000.0;
  double drift_from_s_ = 1000.0;
  std::int64_t slept_ns_ = 0;
  int burst_left_ = 0;
};

}  // namespace strobe::host_test
