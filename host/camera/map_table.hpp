// A calibration's map as the calibration file says it. Pure; thread-safe; allocates.
#pragma once

#include "host/camera/calibration.hpp"
#include "host/config/camera_table.hpp"

namespace strobe::camera {

/// Sets the map and its errors, and nothing else.
void set_map(const Calibration& found, host::CameraTable& table);

}  // namespace strobe::camera
