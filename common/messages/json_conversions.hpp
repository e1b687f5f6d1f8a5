// Frames and readouts as JSON: one object, one line. Names and units are those of frame.hpp and readout.hpp.
// Numbers are printed with the fewest digits that read back to the same value; keys keep one fixed order.
// What is absent is null in a readout and left out of a frame. Pure functions; thread-safe; they allocate.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/result.hpp"

namespace strobe::messages {

/// Reads one frame. Unknown keys are ignored; null means absent. An error names the field and what it must
/// be, as in "images[3].centre_px: must be two numbers", or the column where the text stops being JSON.
/// reduce() checks whether the frame can be reduced (order of times, ranges).
Result<reduction::Frame> frame_from_json(std::string_view text);

/// Numbers that are not finite become null.
std::string frame_to_json(const reduction::Frame& frame);

nlohmann::ordered_json readout_json(const reduction::Readout& readout);
/// Its text.
std::string readout_to_json(const reduction::Readout& readout);

}  // namespace strobe::messages
