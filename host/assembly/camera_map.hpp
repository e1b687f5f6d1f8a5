// From the rig file's [camera] to the digitizer's map, and what the calibration's errors do to a frame. Pure;
// thread-safe; allocates.
#pragma once

#include "common/reduction/frame.hpp"
#include "host/config/camera_table.hpp"
#include "host/digitize/core/plane_map.hpp"

namespace strobe::host {

/// `height_px` is the photograph's; a calibration has its own.
digitize::PlaneMap plane_map(const CameraTable& camera, int height_px);

/// Sets the frame's map_errors, one for each of the calibration's errors, of images and surface as they are
/// (none without a map), and its lens, where the calibration that made the frame tells it.
void set_calibration(const CameraTable& camera, reduction::Frame& frame);

}  // namespace strobe::host
