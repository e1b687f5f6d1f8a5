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
  Duration local_offset = std::chrono::seconds{7};
  WallTime device_wall{std::chrono::seconds{1'700'000'000}};  ///< less its CLOCK_BOOTTIME
  double lost_share = 0.0;
  double long_share = 0.0;   ///< messages with some milliseconds more
  double burst_share = 0.0;  ///< of messages that begin a burst of ten, 5 to 10 ms late
  double extra_delay_s = 0.0;
  double wander = 0.0;  ///< what the drift's random walk gains per square root of a second

  static constexpr double kDelay_s = 100e-6;  ///< that all messages have; usual ones vary by kJitter_s
  static constexpr double kJitter_s = 20e-6;

  struct Beat {
    host::DeviceReading device;
    HostTime heard;
    /// This machine's clock less the device's, with the delay.
    Duration offset() const { return heard.time_since_epoch() - device.mono.time_since_epoch(); }
  };
  /// Half a second later: one more heartbeat, unless it is lost.
  std::optional<Beat> next() {
    device_s_ += 0.5;
    if (wander > 0.0) change_drift(std::normal_distribution<double>(drift, wander * std::sqrt(0.5))(random_));
    const double delay_s = draw_delay_s();
    if (uniform() < lost_share) return std::nullopt;
    const Duration since_boot = device().time_since_epoch() + slept_;
    return Beat{{device(), device_wall + since_boot, since_boot}, local() + ns_of(delay_s)};
  }
  void send(host::DeviceClock& clock) {
    if (const auto beat = next()) clock.on_heartbeat(boot_id, beat->device, beat->heard);
  }

  MonoTime device() const { return MonoTime{ns_of(device_s_)}; }
  /// This machine's clock less the device's.
  Duration offset() const { return local_offset + ns_of(drift * (device_s_ - drift_from_s_)); }
  double offset_s() const { return to_seconds(offset()); }
  /// This machine's clock at device().
  HostTime local() const { return HostTime{device().time_since_epoch() + offset()}; }

  void change_drift(double to) {
    local_offset = offset();
    drift_from_s_ = device_s_;
    drift = to;
  }
  void suspend(double seconds) {
    slept_ += ns_of(seconds);
    local_offset += ns_of(seconds);
  }
  void reboot() {
    reboot_to(10.0, local() + std::chrono::seconds{30});
    boot_id = 99;
  }
  /// The clock of a machine that was started so long ago, at an instant of this machine's.
  void reboot_to(double device_s, HostTime at) {
    device_s_ = drift_from_s_ = device_s;
    local_offset = at - HostTime{device().time_since_epoch()};
    slept_ = {};
  }

 private:
  static Duration ns_of(double s) { return Duration{static_cast<std::int64_t>(s * 1e9)}; }
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
  double device_s_ = 1000.0, drift_from_s_ = 1000.0;
  Duration slept_{};
  int burst_left_ = 0;
};

}  // namespace strobe::host_test
