#include "host/camera/map_table.hpp"

#include <algorithm>

namespace strobe::camera {

void set_map(const Calibration& found, host::CameraTable& table) {
  host::CameraMap& map = table.map.emplace();
  map.lens_centre_px = {found.lens.centre_px.x, found.lens.centre_px.y};
  map.lens_focal_px = found.lens.focal_px;
  map.lens_distortion = {found.lens.k1, found.lens.k2, found.lens.p1, found.lens.p2};
  std::copy(found.rectify.val, found.rectify.val + 9, map.rectify.begin());
  table.map_errors.clear();
  for (const MapError& error : found.map_errors) {
    host::CameraMapError& into = table.map_errors.emplace_back();
    std::copy(error.rectify.val, error.rectify.val + 9, into.rectify.begin());
    into.lens_distortion = error.lens_terms;
  }
}

}  // namespace strobe::camera
