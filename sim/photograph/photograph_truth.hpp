// True values of a photograph's images. Coordinates are plane px: those of a frame, as on
// the photograph (x the column, y upwards from the middle of the lowest row) but with the lens's distortion and the
// camera's tilt undone; perspective is left as it is. Thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "sim/photograph/lit_balls.hpp"

namespace strobe::sim {

/// One image of the ball.
struct ImageTruth {
  int flash_index = 0;           ///< of its pulse in the exposure
  double time_s = 0.0;           ///< middle of the flash, from the exposure's first pulse's edge on
  reduction::Leg leg{};          ///< contact: flattened, however little
  reduction::PointPx centre_px;  ///< of the outline (camera.hpp); in contact of the round part of it
  double diameter_px = 0.0;      ///< of the disc of the round outline's area
  double equator_rad = 0.0;      ///< modulo pi; of the line through the two ends of the line on the outline
  reduction::PointPx top_px;     ///< the outline's point farthest from the surface
  double top_drop_px = 0.0;      ///< by how much the ball is pressed flat
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
