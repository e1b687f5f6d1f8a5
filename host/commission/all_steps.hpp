// The steps of commissioning, in their order. Pure; allocates; thread-safe.
#pragma once

#include <memory>
#include <vector>

#include "host/commission/core/step.hpp"

namespace strobe::commission {

std::vector<std::unique_ptr<Step>> all_steps();

/// Of all of them, in their order: what a record should hold.
std::vector<StepInfo> all_infos();

}  // namespace strobe::commission
