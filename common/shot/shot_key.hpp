// Which shot: unique over all boots of a rig's firmware. Plain value; real-time safe.
#pragma once

#include <compare>
#include <cstdint>

namespace strobe {

struct ShotKey {
  std::int64_t boot_id = 0;
  std::int32_t shot_id = 0;

  auto operator<=>(const ShotKey&) const = default;
};

// Ranges of the events that a firmware numbers from 1 within a boot. Plain values; real-time safe.

/// First and last sequence number, both included.
struct SequenceRange {
  std::int64_t first = 0;
  std::int64_t last = 0;

  bool operator==(const SequenceRange&) const = default;
};

/// Events of one boot: what a host that misses them asks for.
struct EventRange {
  std::int64_t boot_id = 0;
  SequenceRange sequences;

  bool operator==(const EventRange&) const = default;
};

}  // namespace strobe
