// A shot that is asked for, as plan_t carries it. Plain value; real-time safe.
#pragma once

#include <cstdint>

#include "common/shot/coded_train.hpp"
#include "common/units/time.hpp"

namespace strobe {

/// Free: flashes run from the shutter's opening to its closing. Gated: a burst starts a delay after the light
/// gate. Values are those of plan_t.
enum class Train : std::int8_t { free = 0, gated };

struct ShotPlan {
  Train train = Train::free;
  Duration period{};             ///< of an even train
  std::int32_t flash_count = 0;  ///< gated: flashes of the burst; free: 0
  Duration exposure{};           ///< the shutter is open for so long
  Duration gate_delay{};         ///< gated: gate edge to first flash
  Duration impact_at{};          ///< shutter's opening to the ball's impact; 0: as the rig file has it
  bool dry = false;              ///< lamps and shutter only, the machine is not triggered
  CodedTrain code{};             ///< empty: an even train

  bool operator==(const ShotPlan&) const = default;
};

}  // namespace strobe
