// Outlines fitted once more with the size that the certain balls agree on.
#pragma once

#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"
#include "host/digitize/outliers/selection.hpp"
#include "host/digitize/outline/outlines.hpp"

namespace strobe::digitize {

/// An outline whose diameter differs from the others' has used another's edge, and one that was left out for
/// it, or as imprecise, perhaps, too. They are fitted again with the others' size as the prior, and with the
/// others' edges left to them. A fit takes an outline's place if its centre is no less certain; what is found
/// where no outline is moves from `unmeasured` to the end of `outlines`. With fewer than four outlines
/// nothing is done. `settings` as for the first fit. Deterministic; no I/O; thread-safe; allocates.
void refit_by_size(const Photograph& photograph, const PlaneMap& map, OutlineSettings settings,
                   const SizeModel& size, std::vector<Outline>& outlines,
                   std::vector<Unmeasured>& unmeasured);

}  // namespace strobe::digitize
