// Why a packet of telemetry is not known to be the lab's, and how many were not. Values only.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace strobe::authentication {

enum class Unverified {
  unsealed,   ///< without a seal, or cut
  other_key,  ///< sealed with another key, by what it says itself
  altered,    ///< says that it is sealed with this key, and is not: forged, altered, or of another channel
  replayed,   ///< came before, or is older than all that its sender's packets are told apart by
};
inline constexpr std::size_t kUnverifiedCount = 4;

/// For programs.
constexpr const char* name(Unverified why) {
  constexpr const char* kNames[kUnverifiedCount] = {"unsealed", "other_key", "altered", "replayed"};
  return kNames[static_cast<std::size_t>(why)];
}

/// For a person, after a number.
constexpr const char* words(Unverified why) {
  constexpr const char* kWords[kUnverifiedCount] = {"not sealed", "sealed with another key", "altered",
                                                    "repeated"};
  return kWords[static_cast<std::size_t>(why)];
}

struct UnverifiedCounts {
  std::array<std::int64_t, kUnverifiedCount> counts{};
  std::int64_t& operator[](Unverified why) { return counts[static_cast<std::size_t>(why)]; }
  std::int64_t operator[](Unverified why) const { return counts[static_cast<std::size_t>(why)]; }
  std::int64_t sum() const { return std::accumulate(counts.begin(), counts.end(), std::int64_t{0}); }
};

}  // namespace strobe::authentication
