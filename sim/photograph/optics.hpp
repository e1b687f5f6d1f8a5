// From a pixel of the photograph back through the lens to the ray that it looks along. The inverse of
// sim/rig/camera.hpp. Plain values, thread-safe, no allocation.
//
// Coordinates: "image px" are columns and rows (from the top) with pixel centres at integers. "Axis
// coordinates" are metres from the view's axis in the plane that balls are to fly in: x to the right along
// the surface, y up, z towards the lens; the surface is at y = -height_m/2.
#pragma once

#include "sim/rig/slant.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

struct Vec2 {
  double x = 0.0;
  double y = 0.0;
};

struct Vec3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double f, const Vec3& a) { return {f * a.x, f * a.y, f * a.z}; }
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// The sensor's size: the scene's, or what holds its view.
struct SensorSize {
  int width = 0;
  int height = 0;
};
SensorSize sensor_size(const Scene& scene);

class Optics {
 public:
  explicit Optics(const Scene& scene);

  /// Where the ray through that place of the photograph meets the balls' plane. A place that no ray meets
  /// (beyond the reach of a strong barrel distortion) is given the farthest one that is met.
  Vec2 plane_at(double column, double row) const;

  /// Where a point is seen on the photograph, lens included.
  Vec2 image_of(const Vec3& point) const;

  /// Axis coordinates of a point on and over the surface.
  Vec3 from_surface(double x_m, double y_m, double off_plane_m) const;
  double surface_y() const { return -half_height_m_; }

  bool perspective() const { return distance_m_ > 0.0; }
  double distance_m() const { return distance_m_; }  ///< lens to plane; 0: infinitely far
  double px_per_m() const { return px_per_m_; }
  const SensorSize& sensor() const { return sensor_; }

 private:
  SensorSize sensor_;
  double px_per_m_;
  double origin_x_px_;
  double origin_y_px_;
  double half_height_m_;
  double distance_m_;
  bool mirrored_;
  double turn_cos_;
  double turn_sin_;
  double bend_pm2_ = 0.0;
  Slant slant_;
  Eigen::Vector2d foot_px_ = Eigen::Vector2d::Zero();  ///< of the axis; x to the right, y up
};

}  // namespace strobe::sim
