// Whether the lamps light the picture as they should. Pure; allocates; thread-safe.
#pragma once

#include <vector>

#include "host/commission/camera/lamp_light.hpp"
#include "host/commission/core/step_result.hpp"
#include "host/config/commission_table.hpp"

namespace strobe::commission {

/// Light of a hundred flashes that vary by 5 % is known to 0.5 %, of A + B - both to 0.9 %.
inline constexpr double kMaxExcess = 0.05;
/// Of the short trains' light: 16 flashes that vary by 5 % scatter by 1.3 %; a flash that the shutter cuts off is 6 %.
inline constexpr double kMinEdgeLight = 0.85;

StepResult judge_light(const std::string& id, const LampLight& light, const host::CommissionTable& limits);
/// Whether the shutter is open from the first flash to the last.
StepResult judge_exposure_window(const std::string& id, const LampLight& light);

}  // namespace strobe::commission
