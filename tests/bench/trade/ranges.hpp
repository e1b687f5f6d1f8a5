// What the scenes of the studies spanned, for programs that are asked beyond it. Deterministic; allocates.
#pragma once

#include <string>

#include "tests/bench/trade/study.hpp"

namespace strobe::bench::trade {

/// The text of ranges.csv; see common/data/frontier/README.md.
std::string ranges_text(const Effort& effort);

}  // namespace strobe::bench::trade
