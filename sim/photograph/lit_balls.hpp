// The balls lit by an exposure's flashes, if any part of them is on the sensor: both the rendering and the
// truth use them. Thread-safe; allocates.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "sim/photograph/appearance.hpp"
#include "sim/rig/exposure.hpp"

namespace strobe::sim {

/// One ball at one instant. A ball in contact is a sphere whose top is lowered by top_drop_m, cut off by the
/// surface.
struct LitBall {
  Vec3 centre;             ///< of the sphere, axis coordinates
  double angle_rad = 0.0;  ///< of its line, counter-clockwise in axis coordinates, at the middle of the view
  std::array<double, 2> light{};  ///< of each lamp, over that of a usual flash
  /// From the ball's own axes to axis coordinates, besides the turn by angle_rad that comes first; absent: it
  /// has turned about z only.
  std::optional<Eigen::Matrix3d> turned{};

  Eigen::Matrix3d attitude() const;
};

struct BallImageOnSensor {
  FilmImage film;
  LitBall middle;              ///< in the middle of the flash
  std::vector<LitBall> balls;  ///< spread over the flash where the ball moves visibly; at least one
};

/// Of the balls that a fault throws besides the shot's.
std::vector<BallImageOnSensor> more_lit_balls(const Scene& scene, const Exposure& exposure,
                                              const Appearance& appearance);

/// In order of time.
std::vector<BallImageOnSensor> lit_balls(const Scene& scene, const Exposure& exposure,
                                         const Appearance& appearance);

/// Light of each lamp in all flashes of the exposure while the shutter was open.
std::array<double, 2> light_of_all(const Exposure& exposure, const Appearance& appearance, double power_sd);

/// The outline of a ball as seen on the photograph, lens included: points around it, counter-clockwise. Not
/// cut off by the surface.
std::vector<Vec2> outline_on_sensor(const Optics& optics, const Vec3& centre, double radius_m, int points);

// True values of a photograph's images. Coordinates are plane px: those of a frame, as on
// the photograph (x the column, y upwards from the middle of the lowest row) but with the lens's distortion
// and the camera's tilt undone; perspective is left as it is. Thread-safe; allocates.

/// One image of the ball.
struct ImageTruth {
  int flash_index = 0;            ///< of its pulse in the exposure
  double time_s = 0.0;            ///< middle of the flash, from the exposure's first pulse's edge on
  reduction::Leg leg{};           ///< contact: flattened, however little
  reduction::PointPx centre_px;   ///< of the outline (camera.hpp); in contact of the round part of it
  double diameter_px = 0.0;       ///< of the disc of the round outline's area
  double equator_rad = 0.0;       ///< modulo pi; of the line through the two ends of the line on the outline
  double equator_tilt_rad = 0.0;  ///< as reduction::BallImage has it, of that direction
  double depth_m = 0.0;           ///< of the centre from the plane that balls are to fly in, to the lens
  reduction::PointPx top_px;      ///< the outline's point farthest from the surface
  double top_drop_px = 0.0;       ///< by how much the ball is pressed flat
  std::optional<double> contact_width_px;  ///< of the flat side; absent in the air
  bool whole = true;                       ///< entirely within the border
  double share_on_sensor = 1.0;            ///< of the outline
};

struct PhotographTruth {
  int width_px = 0;
  int height_px = 0;
  double px_per_m = 0.0;                       ///< in the plane that balls are to fly in
  double px_per_m_of_ball = 0.0;               ///< in the plane in which this ball flew
  std::vector<reduction::PointPx> surface_px;  ///< two points of the surface's line
  /// Of each pulse the mean of its sensors' edges, from the first pulse's edge on; absent: no sensor saw it.
  std::vector<std::optional<double>> flash_times_s;
  std::vector<ImageTruth> images;  ///< in order of time
};

PhotographTruth photograph_truth(const Scene& scene, const Exposure& exposure, const Appearance& appearance,
                                 const std::vector<BallImageOnSensor>& images);

/// One JSON object on one line, without the newline: all of truth_line() (sim/rig/truth.hpp), and `file`
/// (null where it is not known), the truth's names as above (null for what is absent), `ball_diameter_m` and
/// `appearance`.
std::string photograph_line(const Scene& scene, const Exposure& exposure, int shot_id,
                            const Appearance& appearance, const PhotographTruth& truth,
                            const std::string& file);

}  // namespace strobe::sim
