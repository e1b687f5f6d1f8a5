// Port: edges of the inputs, stamped by the kernel, and their levels.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/units/time.hpp"

namespace strobe::firmware {

enum class Input { sensor_a, sensor_b, gate, key, estop, xsync };

struct Edge {
  Input input = Input::sensor_a;
  MonoTime time;        ///< the kernel's stamp
  bool active = false;  ///< logical level after the edge; sensors and gate report their active edges only
};

/// One thread's. Real-time safe but for the sleep that wait() is.
class EdgeSource {
 public:
  virtual ~EdgeSource() = default;
  /// Sleeps until an edge, a wake-up (a command) or the instant; not at all if that has passed. Fills `edges`
  /// from its start and returns their number; what did not fit comes with the next call. Returns nullopt if
  /// the inputs cannot be read.
  virtual std::optional<std::size_t> wait(MonoTime until, std::span<Edge> edges) noexcept = 0;
  /// The same without sleeping: polls the inputs until there is something or the instant has come. A virtual
  /// clock may skip the time between.
  virtual std::optional<std::size_t> poll(MonoTime until, std::span<Edge> edges) noexcept = 0;
  /// Logical level now. Returns nullopt if it cannot be read.
  virtual std::optional<bool> level(Input input) noexcept = 0;
  /// Edges that a kernel buffer lost since the start, or, where the kernel does not count them, how often it
  /// was found full, so that some may have been.
  virtual std::int64_t kernel_overflows() const noexcept = 0;
};

}  // namespace strobe::firmware
