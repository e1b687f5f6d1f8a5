// A camera's clock on this machine's CLOCK_MONOTONIC. An exchange asks the camera to keep its time (a latch),
// between two readings of this machine's clock: it did so in between, however the delay was divided between
// the ways there and back. Each exchange bounds the offset from both sides, and the relation is any line
// within all bounds of the last half minute (A. Duda, G. Harrus, Y. Haddad, G. Bernard: Estimating global
// time in distributed systems, ICDCS 1987). An exchange that took long bounds little, and does no harm. The
// truth is never farther from what is given than sqrt(3) of its stated sd: that of an even distribution over
// all lines that are possible. No I/O; deterministic; one thread's.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "common/units/time.hpp"

namespace strobe::host {

struct ClockExchange {
  HostTime before, after;      ///< this machine's clock
  std::int64_t camera_ns = 0;  ///< the camera's in between
};

/// An instant of the camera's clock on this machine's.
struct CameraInstant {
  HostTime instant;
  Duration sd{};  ///< > 0
};

class CameraClock {
 public:
  /// resolution: what the camera's stamps are rounded down to, >= 0.
  explicit CameraClock(Duration resolution = Duration{1}) : resolution_(resolution) {}

  /// One that contradicts earlier ones ends their relation: the camera was started anew, or its clock set.
  void on_exchange(const ClockExchange& exchange);
  /// Returns nullopt before the first exchange.
  std::optional<CameraInstant> local(std::int64_t camera_ns) const;
  /// How often relations have ended.
  int restarts() const { return restarts_; }

 private:
  /// What an exchange says of the offset, this machine's clock less the camera's.
  struct Bounds {
    double at_s = 0.0;  ///< of the camera's clock, from the origin
    double low_ns = 0.0, high_ns = 0.0;
    HostTime heard;
  };
  double highest_ns(double at_s) const;
  double lowest_ns(double at_s) const;
  bool possible() const;

  Duration resolution_;
  std::int64_t origin_camera_ns_ = 0;
  Duration origin_offset_{};  ///< numbers are kept relative to it
  std::deque<Bounds> bounds_;
  int restarts_ = 0;
};

}  // namespace strobe::host
