// The calibration of the camera from photographs of a printed board. The first photograph has the board in
// the plane in which balls fly: its homography is the scale and undoes the tilt. The others may have it
// anywhere; all of them tell the lens, and the slanted ones the focal length (Zhang 2000), and with it where
// the lens is. Deterministic; thread-safe; allocates; no I/O.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/camera/board.hpp"
#include "host/camera/board_fit.hpp"
#include "host/config/camera_table.hpp"
#include "host/digitize/core/plane_map.hpp"

namespace strobe::camera {

// What the board's points leave open of the map from the photograph to the plane: the parameters' covariance
// as a few independent errors of the whole map. Deterministic; thread-safe; allocates; no I/O.

/// How the map changes by one standard deviation of one error. Added to Calibration::rectify and the lens'
/// terms.
struct MapError {
  cv::Matx33d rectify;                 ///< (2, 2) = 0
  std::array<double, 4> lens_terms{};  ///< k1, k2, p1, p2
};

struct CalibrationSettings {
  int width_px = 0;
  int height_px = 0;
  double spacing_sd_share = 0.0;             ///< of the board's print, as a share; 0 to 0.1
  double off_plane_sd_m = 0.0;               ///< between the board's plane and the balls', >= 0
  std::optional<double> lens_distance_m;     ///< of the lens from that plane, by a tape, > 0
  std::optional<double> lens_distance_sd_m;  ///< default 1 %
  /// Largest ScaleErrors::points that is good enough, as a share, above 0. What a careful board's print and
  /// place leave is 0.1 %; a map twice as uncertain as that would spoil it.
  double tolerance_share = 0.002;
};

/// Of the scale, as shares of it.
struct ScaleErrors {
  double points = 0.0;  ///< of the board's points, rms over the photograph: in Calibration::map_errors
  double print = 0.0;   ///< of the board's print
  std::optional<double> off_plane;  ///< of its place; absent: the lens' distance is not known
  double total() const;
  /// Without the points' share.
  double common() const;
};

/// Where the lens is, as far as the photographs or a tape tell.
struct LensPosition {
  digitize::Viewpoint viewpoint;
  double distance_sd_px = 0.0;
  double focal_px = 0.0;
  double tilt_rad = 0.0;  ///< of the optical axis against the plane's normal, 0 to pi/2
};

struct Calibration {
  digitize::LensDistortion lens;
  /// undistorted image px to plane px; near the photograph's centre plane px are image px
  cv::Matx33d rectify;
  double px_per_m = 0.0;  ///< of plane px
  ScaleErrors scale_errors;
  std::optional<LensPosition> place;  ///< absent: the distance would be uncertain by more than a quarter
  BoardFit fit;
  double covered_share = 0.0;        ///< of the photograph by the board in the plane
  double largest_shift_px = 0.0;     ///< by the lens, at the photograph's corners
  std::vector<std::string> remarks;  ///< for a person: what may be doubted
  std::vector<MapError> map_errors;  ///< what the points leave open
  /// Present if the points leave more open than the settings' tolerance: how much, and what to do. It should
  /// not be used.
  std::optional<std::string> too_poor;

  double px_per_m_sd() const { return px_per_m * scale_errors.total(); }
  digitize::PlaneMap map() const;
};

/// Fails with a line if settings are out of range or the boards fit no camera.
Result<Calibration> calibrate(std::span<const BoardView> views, const CalibrationSettings& settings);

// How uncertain the scale is all over the photograph, as the points' noise makes it. Pure; thread-safe;
// allocates.

/// From image px to metres on the board of a homography, y as it comes.
digitize::PlaneMap board_map(const digitize::LensDistortion& lens, const cv::Matx33d& homography);

/// How the scale at places all over the photograph, a row each, changes with each of the fit's parameters, as
/// shares of it (CV_64F).
cv::Mat scale_slopes(const BoardFit& fit, const CalibrationSettings& settings);

/// ScaleErrors::points: the scale's sd as a share, rms over the places, for the parameters' covariance.
double scale_sd_share(const cv::Mat& slopes, const cv::Mat& covariance);

/// What would be left of it were the lens known.
double scale_sd_share_of_known_lens(const cv::Mat& slopes, const cv::Mat& covariance);

// A calibration's map as the calibration file says it. Pure; thread-safe; allocates.

/// Sets the map and its errors, and nothing else.
void set_map(const Calibration& found, host::CameraTable& table);

}  // namespace strobe::camera
