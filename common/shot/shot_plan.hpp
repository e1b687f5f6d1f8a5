// A shot that is asked for: its lamps, its train, its times. Plain values; real-time safe.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstddef>
#include <cstdint>

#include "common/units/time.hpp"

namespace strobe {

enum class Lamps : std::int8_t { a = 1, b = 2, both = 3 };  ///< bits; values are those of coded_flash_t

constexpr bool has_a(Lamps lamps) { return (static_cast<int>(lamps) & 1) != 0; }
constexpr bool has_b(Lamps lamps) { return (static_cast<int>(lamps) & 2) != 0; }

// A coded train: flashes at instants of their own, of both lamps or of one. Never allocates; copying takes as
// long as the train is, so that the room for the longest one costs nothing. Real-time safe.

inline constexpr std::size_t kMaxCodedFlashes = 1024;

struct CodedFlash {
  Duration offset{};  ///< from the train's first instant
  Lamps lamps = Lamps::both;

  bool operator==(const CodedFlash&) const = default;
};

/// In order of time. Throws if it is full.
using CodedTrain = boost::container::static_vector<CodedFlash, kMaxCodedFlashes>;

// A shot that is asked for, as plan_t carries it. Plain value; real-time safe.

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

/// From the train's first instant to its last flash.
inline Duration train_length(const ShotPlan& plan, std::int32_t flashes) {
  return plan.code.empty() ? plan.period * (flashes - 1) : plan.code.back().offset;
}

}  // namespace strobe
