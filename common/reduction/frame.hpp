// A digitized photograph with the time of each image: what the reduction starts from. Axes of the photograph:
// x right, y up, in pixels (or tablet units). Plain values and pure functions; thread-safe.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/flight/air_law.hpp"
#include "common/shot/leg.hpp"

namespace strobe::reduction {

using strobe::Leg;

/// A point of the photograph. [px]
struct PointPx {
  double x = 0.0;
  double y = 0.0;
};

/// One image of the ball.
struct BallImage {
  double time_s = 0.0;     ///< middle of the flash, any origin common to the frame
  std::optional<Leg> leg;  ///< absent: found by the reduction
  PointPx centre_px;
  double diameter_px = 0.0;           ///< > 0
  std::optional<double> equator_rad;  ///< counter-clockwise from +x, modulo pi; absent: not seen
  /// Of the plane that the line lies in, out of the line of sight, -pi/2 to pi/2: what is seen of the line is
  /// displaced to the left of somebody who goes along it in the direction equator_rad. The same line is
  /// (equator_rad + pi, -equator_tilt_rad). Its normal, with x right, y up and z from the ball to the lens,
  /// is
  /// (-sin e cos t, cos e cos t, -sin t). With an equator and its sd only; absent: not measured.
  std::optional<double> equator_tilt_rad;
  std::optional<double> equator_tilt_sd_rad;       ///< with equator_tilt_rad
  std::optional<double> equator_tilt_correlation;  ///< with equator_rad, -1 to 1; absent: 0
  std::optional<double> time_sd_s;
  std::optional<int> flash_index;
  std::optional<std::array<double, 4>> centre_cov_px2;  ///< row-major 2x2; overrides Frame::centre_sd_px
  std::optional<double> diameter_sd_px;                 ///< overrides Frame::diameter_sd_px
  std::optional<double> equator_sd_rad;                 ///< overrides Frame::equator_sd_rad
  std::optional<PointPx> top_px;                        ///< top of the ball, contact images
  std::optional<double> contact_width_px;
  /// That it is one of the ball's images, above 0 to 1, as whoever measured it says before anything is
  /// fitted; absent: not stated.
  std::optional<double> probability;
  std::string source;  ///< "auto", "hand" or empty
  /// In flight before or after another bounce than the frame's: for the operator only, it may have no time.
  /// Messages and the JSON reader leave it out.
  bool other_leg = false;
};

/// What one standard deviation of one of the camera calibration's independent errors does to the frame: all
/// its points move together, so that no residual shows it. [px, rad]
struct MapError {
  struct Shift {
    PointPx centre_px;
    double diameter_px = 0.0;
    double equator_rad = 0.0;  ///< 0 where no equator was seen
  };
  std::vector<Shift> images;        ///< one for each of the frame's
  std::vector<PointPx> surface_px;  ///< likewise
};

/// Where the camera's lens was: how what is nearer or farther than the plane that balls fly in is seen. In
/// the photograph's px a point at a height z above that plane is seen away from the foot by 1 / (1 -
/// z/distance). Of a frame that has one, centres and diameters are the spheres' own: that a ball aside of the
/// axis is seen as an oval, larger by the root of the angle's inverse cosine, is undone.
struct Lens {
  double distance_m = 0.0;  ///< from the plane, 0.01 to 1e6
  PointPx foot_px;          ///< where the perpendicular through the lens meets the plane
};

/// The session's record: free key-value notes (frame number, ball, surface, operator, remarks ...).
using Record = std::map<std::string, std::string>;

inline constexpr double kMinTemperature_degC = -60.0;
inline constexpr double kMaxTemperature_degC = 100.0;

/// A digitized photograph. Images are in order of time, a nanosecond apart or more, times within 1e9 s. What
/// is absent was not known. Coordinates and lengths in pixels are within 1e12 either way, diameters and
/// standard deviations 1e-9 to 1e12 px, angles within 1e6 rad and their standard deviations 1e-9 to 1e6 rad:
/// the fit's squares then neither overflow nor vanish.
struct Frame {
  int shot_id = 0;
  double ball_diameter_m = 0.0;              ///< 0.01 to 1
  std::optional<double> ball_diameter_sd_m;  ///< the diameter's tolerance as a standard deviation
  /// At least 2 points of the surface line; none: a photograph of one flight without a bounce, whose images
  /// are all of one leg, labelled or not, and none in contact.
  std::vector<PointPx> surface_px;
  std::optional<double> surface_sd_px;  ///< of each coordinate; absent: as centre_sd_px
  std::optional<double> centre_sd_px;   ///< of each coordinate
  std::optional<double> diameter_sd_px;
  /// Of what all diameters are off alike, as limbs of one photograph are lit alike: as if the ball were of
  /// another size. In the diameters' own sds, too. At least 0
  std::optional<double> shared_diameter_sd_px;
  std::optional<double> equator_sd_rad;
  std::optional<double> px_per_m;  ///< calibrated scale; absent: from the ball's diameter, which joins in
                                   ///< where it is the better known
  std::optional<double>
      px_per_m_sd;  ///< 0: the calibrated scale is exact; absent: likewise, but the readout is flagged
  std::optional<Lens> lens;  ///< calibrated; absent: unknown, or far away
  /// Of the calibration that made the coordinates; what they do to the scale is not in px_per_m_sd. At most
  /// 64.
  std::vector<MapError> map_errors;
  /// Inclination of the plate against the horizontal, from an inclinometer; without a surface of the
  /// photograph's x axis.
  double surface_angle_deg = 0.0;
  std::optional<double> temperature_c;  ///< of the ball and the air, -60 to 100
  std::optional<double> ball_mass_kg;   ///< 0.001 to 10; absent: the thesis's 57.6 g. For drag and lift
  std::optional<double> ball_alpha;     ///< I / (m R^2), above 0 to 2/3; absent: 0.55. For the regime
  std::optional<double> ball_alpha_sd;  ///< 0 to 2/3; absent: ball::kAlphaSd, as balls differ
  /// Before the bounce the ball spun no faster, either way: what its machine can do, say. Absent:
  /// kFastestRim_mps is assumed where the flashes leave it open, and that is flagged.
  std::optional<double> fastest_spin_radps;
  std::optional<double> air_density_kgpm3;  ///< 0 to 100; absent: dry air of the temperature, 1.204 without
  bool line_drawn = true;                   ///< around the ball; without one no spin is expected
  std::optional<flight::AirLaw> air_law;    ///< of this kind of ball; absent: a tennis ball's
  Record record;
  std::vector<BallImage> images;
};

/// What the noise that a frame states is taken for.
enum class NoiseSource {
  stated,     ///< it is believed
  residuals,  ///< relative weights: one factor for each kind of measurement is estimated from the residuals,
              ///< and sds are scaled by Student's t
};

constexpr std::optional<NoiseSource> noise_source_from_name(std::string_view text) {
  if (text == "stated") return NoiseSource::stated;
  if (text == "residuals") return NoiseSource::residuals;
  return std::nullopt;
}

/// What is wrong with the frame, naming the field. Returns nullopt if it can be reduced.
std::optional<std::string> validation_error(const Frame& frame);

/// The frame's temperature, else the record's if that is a number within the valid range, else nullopt.
std::optional<double> temperature_c(const Frame& frame);

}  // namespace strobe::reduction
