// A flash train for balls that are dropped. The images of the way down and of the way up lie on one line, and
// the ball comes at any instant between two flashes, so that no train keeps all images apart. What decides is
// the step from one flash to the next where the ball is fastest: near a diameter two images of one leg touch
// each other, and where the legs' images meet enough of each outline is left. Shorter, images hide each
// other; longer, a leg has too few of them to be told from the other. Nor may the top of a flight be lit,
// where a slow ball's images lie on one another. Pure; thread-safe; allocates.
#pragma once

#include "common/result.hpp"
#include "host/config/plan_file.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::host {

/// The plan with period, exposure and instant of impact for its drop_height_m > 0, for the rig's ball in air
/// of the record's temperature; a period or intervals that are stated are kept. Fails for a person, with what
/// would do, where flashes would be too close or too few.
Result<PlanFile> drop_plan(const PlanFile& plan, const RigFile& rig);

}  // namespace strobe::host
