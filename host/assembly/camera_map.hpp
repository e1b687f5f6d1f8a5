// From the rig file's [camera] to the digitizer's map, and what the calibration's errors do to a frame. Pure;
// thread-safe; allocates.
#pragma once

#include <vector>

#include "common/reduction/frame.hpp"
#include "host/config/camera_table.hpp"
#include "host/digitize/core/plane_map.hpp"

namespace strobe::host {

/// `height_px` is the photograph's; a calibration has its own.
digitize::PlaneMap plane_map(const CameraTable& camera, int height_px);

/// One for each of the calibration's errors, of the frame's images and surface as they are; none without a
/// map.
std::vector<reduction::MapError> map_errors(const CameraTable& camera, const reduction::Frame& frame);

}  // namespace strobe::host
