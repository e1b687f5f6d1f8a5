// When the flashes of photographs were: a file of `strobe digitize --times`, or an even train. No shared
// state.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "common/shot/shot_plan.hpp"

namespace strobe::host {

/// Reads JSON lines, each an array of seconds or an object with that array under "flash_times_s" (what else
/// it has is ignored); a null is a flash that no sensor saw and is left out. Times ascend by a nanosecond or
/// more; at most 100,000. Fails with "FILE:LINE: what".
Result<std::vector<std::vector<double>>> parse_flash_times(const std::string& text, const std::string& file);

/// As many flashes as a photograph may hold, the first at 0.
std::vector<double> even_flashes(double period_s);

/// The flashes of a plan, from the train's first instant.
std::vector<double> plan_flashes(const ShotPlan& plan);

/// Of an even train no photograph tells which of its flashes were seen: times and flash numbers then count
/// from the first image.
void count_from_first_image(reduction::Frame& frame);

}  // namespace strobe::host
