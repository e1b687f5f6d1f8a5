// Where balls are photographed and how their images will be measured, as far as it is known before a shot.
// Plain values and pure functions; thread-safe.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "common/ball/ball.hpp"
#include "common/result.hpp"
#include "common/shot/plan_check.hpp"
#include "host/config/rig_file.hpp"
#include "host/design/optics.hpp"

namespace strobe::host {

/// By a person on a tablet, or by `strobe digitize`.
enum class MeasuredBy { hand, digitizer };

/// What of a photograph decides how well the digitizer measures: host/design/digitizer_noise.hpp.
struct ExpectedPicture {
  double blur_px = 0.8;   ///< sd of the lens's blur
  double exposure = 1.0;  ///< 1: the lightest felt of one image has 45 % of what saturates the sensor
  double flash_s = 1e-6;  ///< of a flash's light
};

/// What is seen where no photograph's size is known: as much as a tennis ball's two legs take.
inline constexpr double kUsualWidth_m = 0.72, kUsualHeight_m = 0.46;

struct SetUp {
  CameraTable camera;     ///< scale, its sd, map errors, size of the photograph
  double px_per_m = 0.0;  ///< > 0
  double width_px = 0.0, height_px = 0.0;
  double touchdown_x_px = 0.0;  ///< where balls touch down on the photograph, x right, y up
  double surface_y_px = 0.0;    //
  double spot_sd_m = 0.01;      ///< along the surface, from ball to ball
  bool size_assumed = false;    ///< of the photograph: no rig file said it
  double surface_angle_rad = 0.0;
  double ball_diameter_sd_m = 0.0;
  std::optional<double> temperature_c;
  std::optional<double> fastest_spin_radps;

  std::optional<LensSetUp> lens;  ///< where it is known
  MeasuredBy measured_by = MeasuredBy::digitizer;
  double hand_centre_sd_m = 0.0003;     ///< of a coordinate, on the object's scale
  double hand_equator_sd_rad = 0.0087;  //
  ExpectedPicture picture;

  double flash_time_sd_s = 0.0;  ///< of a flash's time as it is stamped
  double arrival_sd_s = 0.003;   ///< of touchdown about the instant that the plan expects
  double gate_distance_m = 1.0;  ///< light gate to touchdown
  double gate_distance_sd_m = 0.0;
  PlanLimits limits;
  double match_tolerance_percent = 1.0;

  /// Between two flashes of both lamps.
  Duration shortest_interval() const {
    return std::max(limits.lamp_period, limits.flash_interval + microseconds{1});
  }
};

/// As the rig file has it. Touchdown is expected in the middle of the photograph, its surface at `surface_px`
/// or a ninth up. Fails, naming the key, where the file states no scale.
Result<SetUp> set_up_of(const RigFile& rig);

/// The same through this lens, which gives the scale; of its fields the photograph's size is the set-up's.
/// Fails as check(LensSetUp) does.
Result<SetUp> through(const SetUp& set_up, LensSetUp lens);

/// The same through a lens `factor` times as long on the same sensor: more px/m, less is seen.
SetUp with_lens(SetUp set_up, double factor);

}  // namespace strobe::host
