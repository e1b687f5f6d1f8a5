// What the rig file says to the digitizer: the ball, the calibrated scale, the camera. Values; thread-safe.
#pragma once

#include "common/result.hpp"
#include "host/config/rig_file.hpp"
#include "host/digitize/digitize.hpp"

namespace strobe::host {

/// For photographs of that size. Without a scale in the rig file there is none in the settings: it is found. Fails with
/// one line if the camera's photographs have another size.
Result<digitize::DigitizeSettings> digitize_settings(const RigFile& rig, int width_px, int height_px);

}  // namespace strobe::host
