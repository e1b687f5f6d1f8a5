// Frames to and from their LCM messages, readouts to theirs. What is absent is NaN (numbers) or empty (text)
// there. Messages come from outside: they are checked before they are copied; an error names the field.
// Pure functions; thread-safe; they allocate.
#pragma once

#include <cstdint>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/result.hpp"

namespace strobe_msgs {
class frame_t;
class readout_t;
}  // namespace strobe_msgs

namespace strobe::messages {

/// The message knows neither times nor the ball: time_s is 0 in every image and ball_diameter_m is 0; the
/// caller sets both before it reduces the frame, and record and surface angle. A frame without a surface line
/// is converted, too (it cannot be reduced). A contact image without a diameter has 0.
Result<reduction::Frame> frame_from_lcm(const strobe_msgs::frame_t& message);

/// Times and flash indices are not carried. boot_id, host_id and photograph are the caller's to set. Sources
/// other than "auto" and "hand" become the frame's, which is that of most images.
strobe_msgs::frame_t frame_to_lcm(const reduction::Frame& frame);

/// The legacy estimator's `far` and `contact` are not carried.
strobe_msgs::readout_t readout_to_lcm(const reduction::Readout& readout, std::int64_t host_id,
                                      std::int64_t boot_id);

}  // namespace strobe::messages
