// From a pixel of the photograph back through the lens to the ray that it looks along. The inverse of
// sim/rig/camera.hpp. Plain values, thread-safe, no allocation.
//
// Coordinates: "image px" are columns and rows (from the top) with pixel centres at integers. "Axis
// coordinates" are metres from the view's axis in the plane that balls are to fly in: x to the right along
// the surface, y up, z towards the lens; the surface is at y = -height_m/2.
#pragma once

#include <array>
#include <cstdint>

#include "sim/rig/camera.hpp"
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

/// Appearance of one photograph: the scene's settings, with random values for those that they leave open.
/// Plain values; thread-safe.
struct BallAppearance {
  BallSurface surface = BallSurface::felt;
  bool line = true;
  double line_width_m = 0.0025;
  double line_contrast = 0.8;
  double line_steepness = 4.0;  ///< of its profile exp(-ln2·|2x/width|^steepness); 2: a Gaussian
  double line_tilt_rad = 0.0;   ///< the line's plane against the line of sight
  double line_offset = 0.0;     ///< of that plane from the ball's centre, over the radius
  double grain = 0.05;
  double seam_contrast = 0.2;
  double logo_contrast = 0.5;
  double fuzz_px = 0.2;       ///< half width over which the limb fades
  double hair_px = 0.1;       ///< sd of the outline's irregularity
  double falloff = 0.9;       ///< exponent of the cosine of incidence: 1 is Lambert's
  double sheen = 0.15;        ///< share of light that the felt's hair adds towards the limb
  double albedo = 1.0;        ///< over the lightest felt's
  double shine = 0.0;         ///< height of the reflected lamp, over the albedo
  std::uint64_t texture = 1;  ///< seed of grain, seams, logo and hair
};

struct LampAppearance {
  Vec3 place;  ///< axis coordinates
  double power = 1.0;
  double radius_m = 0.05;
};

struct BackgroundAppearance {
  double wall = 0.05;
  double wall_ramp = 0.3;  ///< from one side to the other, relative
  double plate_brightness = 1.0;
  double plate_thickness_m = 0.015;
  double plate_half_length_m = 0.35;
  std::uint64_t clutter = 1;  ///< seed of the objects in the background
};

struct Appearance {
  BallAppearance ball;
  std::array<LampAppearance, 2> lamps;  ///< A to the left, B to the right
  BackgroundAppearance background;
  double blur_px = 0.8;
  double vignetting = 0.1;
  std::uint64_t noise = 1;  ///< seed of the sensor's noise and of the flashes' power
};

/// The appearance of the `shot`-th photograph (1-based). Every draw is taken even if the scene gives the
/// value, so that setting one key does not change another.
Appearance draw_appearance(const Scene& scene, std::uint64_t seed, int shot);

}  // namespace strobe::sim
