// SplitMix64 (Steele et al. 2014). Pure; thread-safe; no allocation.
#pragma once

#include <cstdint>

namespace strobe::sim {

inline constexpr std::uint64_t kSplitMixStep = 0x9e3779b97f4a7c15U;

/// Its output for the state z; the next state is z + kSplitMixStep.
constexpr std::uint64_t hash64(std::uint64_t z) {
  z += kSplitMixStep;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

}  // namespace strobe::sim
