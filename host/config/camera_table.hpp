// The rig file's [camera]: where its photographs arrive, and what is known of its picture, there or in the
// file that `strobe calibrate` writes. Each field is a key of that name. Coordinates: image px, x the column,
// y the row from the top, and plane px, x to the right, y up, one scale everywhere
// (host/digitize/core/plane_map.hpp). No I/O; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/toml_reader.hpp"
#include "common/result.hpp"
#include "common/units/time.hpp"

namespace strobe::host {

/// From image px to plane px: undo the lens, then the tilt.
struct CameraMap {
  std::array<double, 2> lens_centre_px{};   ///< image px
  double lens_focal_px = 1.0;               ///< unit of the distortion's argument, > 0
  std::array<double, 4> lens_distortion{};  ///< k1, k2, p1, p2 as in OpenCV
  std::array<double, 9> rectify{};          ///< row by row: undistorted image px to plane px, homogeneous
};

/// How the map changes by one standard deviation of one of the calibration's independent errors.
struct CameraMapError {
  std::array<double, 9> rectify{};
  std::array<double, 4> lens_distortion{};
};

/// How photographs come.
enum class CameraKind {
  folder,   ///< something else puts files into a folder
  genicam,  ///< GigE Vision, USB3 Vision
  gphoto2,  ///< cameras that libgphoto2 knows
};

/// Which camera, and how it is to be set.
struct CameraConnection {
  CameraKind kind = CameraKind::folder;  ///< key kind = "folder" | "genicam" | "gphoto2"
  std::string serial;                    ///< empty: the only one there is
  std::string address;                   ///< IP address, or libgphoto2's port; empty: looked for
  bool exposure_by_line = true;  ///< key exposure = "line" | "timed", of the plan's length from the line on
  bool delete_from_camera = false;  ///< once a photograph has been taken over
  /// [camera.set]: texts, numbers and booleans by the camera's own names, in place of what its driver sets.
  std::map<std::string, std::string> set;
};

struct CameraTable {
  CameraConnection connection;
  std::optional<std::string> folder;  ///< where the camera's photographs arrive; ~ is not expanded
  double max_age_days = 90.0;         ///< 0.01 to 100,000; an older calibration is warned of
  /// Name of a file beside the rig file, …camera.toml: what follows is read from it, not from the rig file.
  std::optional<std::string> calibration;

  std::optional<int> width_px;  ///< of the photographs that the calibration is for
  std::optional<int> height_px;
  std::optional<double> px_per_m;  ///< of plane px, 1 to 1e7
  /// Of the board's print and place, and of its points where there are no map_errors; 0 to 1e6
  std::optional<double> px_per_m_sd;
  std::optional<CameraMap> map;  ///< present if `rectify` is; absent: the photograph is taken as it is
  /// What the board's points leave open. Key map_errors: 13 numbers each, of rectify and lens_distortion; at
  /// most 64.
  std::vector<CameraMapError> map_errors;
  /// Where the lens is: plane px of the foot of its perpendicular on the plane, and its distance. Key
  /// viewpoint_px = [x, y, distance]; absent: so far away that balls show as circles.
  std::optional<std::array<double, 3>> viewpoint_px;
  std::optional<double> viewpoint_sd_px;  ///< of the distance
  /// Two points of the surface's line, plane px: surface_px = [x, y, x, y]; absent: found on each photograph.
  std::optional<std::array<double, 4>> surface_px;
  double surface_sd_px = 0.5;  ///< of each coordinate; 1e-4 to 1000

  std::optional<std::string> calibrated;  ///< the day, "2026-11-21"
  std::optional<std::string> board;       ///< for a person
  std::optional<int> photographs;         ///< of the board, as used
  std::optional<std::string> left_out;    ///< those that were of no use, and why; for a person
  std::optional<double> residual_px;      ///< rms of the board's points about the fit
  std::optional<double> tilt_deg;         ///< of the optical axis against the plane's normal
};

/// "folder", "genicam", "gphoto2"
std::string_view name(CameraKind kind);

/// Reads [camera]; what is wrong is reported to the table's reader.
CameraTable read_camera(config::TomlTable table);

/// The same camera, but with what the calibration file's text says. Fails with "FILE:LINE: key: what".
Result<CameraTable> with_calibration(const CameraTable& camera, std::string_view text,
                                     const std::string& file_name);

/// The calibration file of it, which reads back to the same bits.
std::string calibration_text(const CameraTable& camera);

/// Whole days from `date` ("2026-11-21") to the day of `now`; absent if it is no date.
std::optional<std::int64_t> days_since(const std::string& date, WallTime now);

/// The day of `now` as "2026-11-21", UTC.
std::string date_of(WallTime now);

/// One line if the calibration is older than max_age_days or without a date. Returns nullopt if it is
/// neither, or if the scale has no sd: that is a first guess, refined on each photograph.
std::optional<std::string> calibration_warning(const CameraTable& camera, WallTime now);

}  // namespace strobe::host
