// Port: the three groups of outputs. Each has a line handle of its own, because a set writes every line of
// its handle.
#pragma once

#include <array>
#include <cstddef>

#include "common/shot/shot_plan.hpp"

namespace strobe::firmware {

enum class Output { trigger, strobes, shutter };
/// In the order in which they are made inactive: the machine first.
inline constexpr std::array<Output, 3> kOutputs{Output::trigger, Output::strobes, Output::shutter};
constexpr std::size_t index_of(Output output) { return static_cast<std::size_t>(output); }

class OutputLines {
 public:
  virtual ~OutputLines() = default;
  /// Drives every line of the output to the logical level in one call. Returns false if it failed. Real-time
  /// safe.
  virtual bool set(Output output, bool active) noexcept = 0;
  /// Output::strobes: makes the named lamps' lines active and the others inactive, in one call; otherwise
  /// likewise.
  virtual bool set_lamps(Lamps lamps) noexcept = 0;
};

}  // namespace strobe::firmware
