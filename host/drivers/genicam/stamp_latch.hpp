// The camera's clock, read at an instant that is known: GigE Vision's registers, or the features
// TimestampLatch (SFNC) and GevTimestampControlLatch. Talks to the camera; one thread's.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/units/time.hpp"
#include "host/clock/camera_clock.hpp"
#include "host/drivers/genicam/camera.hpp"

namespace strobe::genicam {

/// No camera's clock is later; sums with such stamps stay in range.
inline constexpr std::uint64_t kMaxStamp_ns = std::uint64_t{1} << 61;

class StampLatch {
 public:
  /// The first way that gives a clock which goes as fast as this machine's. Returns nullopt if none does.
  static std::optional<StampLatch> find(Camera& camera);

  /// Returns nullopt if the camera does not answer.
  std::optional<host::ClockExchange> exchange(Camera& camera) const;
  /// What stamps are rounded down to.
  Duration resolution() const { return resolution_; }

 private:
  StampLatch() = default;
  bool latch(Camera& camera) const;
  std::optional<std::uint64_t> latched(const Camera& camera) const;
  bool goes_right(Camera& camera) const;

  std::string command_, value_;    ///< features; empty: the registers
  std::uint64_t ticks_per_s_ = 0;  ///< 0: the value is in nanoseconds
  Duration resolution_{1};
};

}  // namespace strobe::genicam
