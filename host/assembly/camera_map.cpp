#include "host/assembly/camera_map.hpp"

#include <cmath>
#include <optional>
#include <vector>

namespace strobe::host {
namespace {

using digitize::PlaneMap;
using reduction::MapError;
using reduction::PointPx;

std::optional<digitize::Viewpoint> viewpoint_of(const CameraTable& camera) {
  if (!camera.viewpoint_px) return std::nullopt;
  const auto& [x, y, distance] = *camera.viewpoint_px;
  return digitize::Viewpoint{{x, y}, distance};
}

PlaneMap map_of(const CameraMap& map, const std::optional<digitize::Viewpoint>& viewpoint) {
  const auto& [k1, k2, p1, p2] = map.lens_distortion;
  const digitize::LensDistortion lens{
      {map.lens_centre_px[0], map.lens_centre_px[1]}, map.lens_focal_px, k1, k2, p1, p2};
  return PlaneMap::calibrated(lens, cv::Matx33d(map.rectify.data()), viewpoint);
}

CameraMap moved(CameraMap map, const CameraMapError& error) {
  for (std::size_t i = 0; i < map.rectify.size(); ++i) map.rectify[i] += error.rectify[i];
  for (std::size_t i = 0; i < map.lens_distortion.size(); ++i)
    map.lens_distortion[i] += error.lens_distortion[i];
  return map;
}

/// What another map makes of a frame's points.
class Shift {
 public:
  Shift(const PlaneMap& map, const PlaneMap& other) : map_(map), other_(other) {}

  PointPx point(const PointPx& p) const {
    const cv::Point2d at = other_.to_plane(map_.to_image({p.x, p.y}));
    return {at.x - p.x, at.y - p.y};
  }

  MapError::Shift image(const reduction::BallImage& image) const {
    const cv::Point2d at = map_.to_image({image.centre_px.x, image.centre_px.y});
    const cv::Matx22d turn = other_.jacobian(at) * map_.jacobian(at).inv();
    MapError::Shift shift;
    shift.centre_px = point(image.centre_px);
    shift.diameter_px = image.diameter_px * (std::sqrt(std::abs(cv::determinant(turn))) - 1.0);
    if (!image.equator_rad) return shift;
    const cv::Vec2d along(std::cos(*image.equator_rad), std::sin(*image.equator_rad));
    const cv::Vec2d now = turn * along;
    shift.equator_rad = std::atan2(along[0] * now[1] - along[1] * now[0], along.dot(now));
    return shift;
  }

 private:
  const PlaneMap& map_;
  const PlaneMap& other_;
};

std::vector<MapError> map_errors(const CameraTable& camera, const reduction::Frame& frame) {
  std::vector<MapError> errors;
  if (!camera.map) return errors;
  const PlaneMap map = map_of(*camera.map, {});
  for (const CameraMapError& error : camera.map_errors) {
    const PlaneMap other = map_of(moved(*camera.map, error), {});
    const Shift shift(map, other);
    MapError& found = errors.emplace_back();
    for (const reduction::BallImage& image : frame.images) found.images.push_back(shift.image(image));
    for (const PointPx& p : frame.surface_px) found.surface_px.push_back(shift.point(p));
  }
  return errors;
}

/// Of a frame in another scale the viewpoint's pixels are not.
std::optional<reduction::Lens> lens_of(const CameraTable& camera, const reduction::Frame& frame) {
  const auto viewpoint = viewpoint_of(camera);
  if (!viewpoint || !frame.px_per_m || frame.px_per_m != camera.px_per_m) return std::nullopt;
  return reduction::Lens{viewpoint->distance_px / *frame.px_per_m,
                         {viewpoint->foot_px.x, viewpoint->foot_px.y}};
}

}  // namespace

PlaneMap plane_map(const CameraTable& camera, int height_px) {
  const auto viewpoint = viewpoint_of(camera);
  if (camera.map) return map_of(*camera.map, viewpoint);
  if (!viewpoint) return PlaneMap::uncalibrated(height_px);
  const cv::Matx33d upside_down(1.0, 0.0, 0.0, 0.0, -1.0, height_px - 1.0, 0.0, 0.0, 1.0);
  return PlaneMap::calibrated({}, upside_down, viewpoint);
}

void set_calibration(const CameraTable& camera, reduction::Frame& frame) {
  frame.map_errors = map_errors(camera, frame);
  frame.lens = lens_of(camera, frame);
}

}  // namespace strobe::host
