// Dry trains by which lamps, sensors and shutter are judged. Pure; thread-safe.
#pragma once

#include "common/shot/lamps.hpp"
#include "common/shot/shot_plan.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::commission {

/// Flashes of these lamps at the rig's own pace; fewer where the rig's limits allow no more. The machine stays still.
ShotPlan dry_train(const host::RigFile& rig, Lamps lamps, int flashes);

}  // namespace strobe::commission
