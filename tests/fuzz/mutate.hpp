// Seeded mutations of fuzzing inputs for builds without libFuzzer. Deterministic, no I/O, thread-safe.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace strobe::fuzz {

/// The input of run `run` under `seed`: one of the seeds (an empty list counts as one empty input), changed
/// by one to eight steps: flipped bits, changed, inserted, removed and repeated bytes, numbers at the edge of
/// their range, a tail taken from another seed. Each run is a function of (seed, run) alone, so that one run
/// can be repeated alone.
std::string mutated(const std::vector<std::string>& seeds, std::uint64_t seed, std::uint64_t run);

}  // namespace strobe::fuzz
