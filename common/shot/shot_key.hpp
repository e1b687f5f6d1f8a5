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

}  // namespace strobe
