// Which forces a flight is computed with. Plain values; thread-safe, real-time safe.
#pragma once

#include <array>
#include <string_view>

namespace strobe::flight {

/// What moves a ball between the flashes.
struct Effects {
  bool gravity = true;
  bool drag = true;
  bool magnus = true;
  bool operator==(const Effects&) const = default;
};
/// Their names, in this order, as in a readout.
inline constexpr std::array<std::string_view, 3> kEffectNames{"gravity", "drag", "magnus"};
inline constexpr std::array<bool Effects::*, 3> kEffectMembers{&Effects::gravity, &Effects::drag,
                                                               &Effects::magnus};

inline constexpr Effects kNoEffects{false, false, false};
inline constexpr Effects kGravityOnly{true, false, false};

}  // namespace strobe::flight
