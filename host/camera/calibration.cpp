#include "host/camera/calibration.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "host/camera/lens_pose.hpp"

namespace strobe::camera {
namespace {

using digitize::PlaneMap;

constexpr int kPlane = 8;  ///< parameters of the first view's homography
constexpr int kParameters = kPlane + 4;
constexpr int kAcross = 5;  ///< points of the photograph, along and down

/// The first view's parameters and the lens' among all.
std::vector<int> indices(const BoardFit& fit) {
  std::vector<int> found;
  for (int i = 0; i < kPlane; ++i) found.push_back(i);
  for (int i = 4; i > 0; --i) found.push_back(static_cast<int>(fit.parameters.size()) - i);
  return found;
}

/// Columns: one sd of independent combinations of the parameters. By way of correlations, since the
/// parameters' sizes differ by many orders.
cv::Mat square_root(const cv::Mat& covariance) {
  cv::Mat sd(covariance.rows, 1, CV_64F), correlation = covariance.clone();
  for (int i = 0; i < covariance.rows; ++i)
    sd.at<double>(i) = std::sqrt(std::max(covariance.at<double>(i, i), 1e-300));
  for (int i = 0; i < covariance.rows; ++i) {
    for (int k = 0; k < covariance.cols; ++k)
      correlation.at<double>(i, k) /= sd.at<double>(i) * sd.at<double>(k);
  }
  cv::Mat values, vectors;  // rows
  cv::eigen(0.5 * (correlation + correlation.t()), values, vectors);
  cv::Mat root = vectors.t();
  for (int k = 0; k < root.cols; ++k) {
    for (int i = 0; i < root.rows; ++i)
      root.at<double>(i, k) *= sd.at<double>(i) * std::sqrt(std::max(0.0, values.at<double>(k)));
  }
  return root;
}

/// undistorted image px to plane px, (2, 2) = 1, of the first view; `to_plane` is from board metres to plane
/// px.
cv::Matx33d rectification(const cv::Matx33d& homography, const digitize::LensDistortion& lens,
                          const cv::Matx33d& to_plane) {
  const double f = lens.focal_px;
  const cv::Point2d c = lens.centre_px;
  const cv::Matx33d normalize(1.0 / f, 0.0, -c.x / f, 0.0, 1.0 / f, -c.y / f, 0.0, 0.0, 1.0);
  const cv::Matx33d rectify = to_plane * homography.inv() * normalize;
  return rectify * (1.0 / rectify(2, 2));
}

class Maps {
 public:
  Maps(const BoardFit& fit, const cv::Matx33d& to_plane)
      : fit_(fit), to_plane_(to_plane), index_(indices(fit)) {}

  cv::Mat covariance() const {
    cv::Mat some(kParameters, kParameters, CV_64F);
    for (int i = 0; i < kParameters; ++i) {
      for (int k = 0; k < kParameters; ++k)
        some.at<double>(i, k) = fit_.covariance.at<double>(index_[static_cast<std::size_t>(i)],
                                                           index_[static_cast<std::size_t>(k)]);
    }
    return some;
  }

  struct Moved {
    digitize::LensDistortion lens;
    cv::Matx33d rectify;
    PlaneMap map() const { return PlaneMap::calibrated(lens, rectify, {}); }
  };

  /// With the parameters changed by `factor` times a column.
  Moved moved(const cv::Mat& column, double factor) const {
    std::vector<double> x = fit_.parameters;
    for (int i = 0; i < kParameters; ++i)
      x[static_cast<std::size_t>(index_[static_cast<std::size_t>(i)])] += factor * column.at<double>(i);
    const auto lens = lens_of(fit_, x);
    return {lens, rectification(homography_of(x, 0), lens, to_plane_)};
  }

 private:
  const BoardFit& fit_;
  const cv::Matx33d& to_plane_;
  std::vector<int> index_;
};

// So small that the map is linear, so large that rounding is none.
constexpr double kStep = 0.01;

/// Plane px by which a grid of points of the photograph moves for each column.
cv::Mat displacements(const Maps& maps, const cv::Mat& root, int width_px, int height_px) {
  cv::Mat moves(2 * kAcross * kAcross, root.cols, CV_64F);
  for (int k = 0; k < root.cols; ++k) {
    const PlaneMap up = maps.moved(root.col(k), kStep).map(), down = maps.moved(root.col(k), -kStep).map();
    for (int i = 0; i < kAcross * kAcross; ++i) {
      const cv::Point2d at((width_px - 1.0) * (i % kAcross) / (kAcross - 1),
                           (height_px - 1.0) * (i / kAcross) / (kAcross - 1));
      const cv::Point2d move = (up.to_plane(at) - down.to_plane(at)) * (0.5 / kStep);
      moves.at<double>(2 * i, k) = move.x;
      moves.at<double>(2 * i + 1, k) = move.y;
    }
  }
  return moves;
}

MapError error_of(const Maps& maps, const cv::Mat& column) {
  const auto up = maps.moved(column, kStep), down = maps.moved(column, -kStep);
  MapError error;
  error.rectify = (up.rectify - down.rectify) * (0.5 / kStep);
  error.lens_terms = {(up.lens.k1 - down.lens.k1) * 0.5 / kStep, (up.lens.k2 - down.lens.k2) * 0.5 / kStep,
                      (up.lens.p1 - down.lens.p1) * 0.5 / kStep, (up.lens.p2 - down.lens.p2) * 0.5 / kStep};
  return error;
}

/// The largest first; those that move no point of the photograph by 0.002 px, a tenth of a centre's noise at
/// its best, are left out. Errors that turn or shift the plane as a whole are among them: surface and balls
/// move alike.
std::vector<MapError> map_errors(const BoardFit& fit, const cv::Matx33d& to_plane, int width_px,
                                 int height_px) {
  constexpr double kSmallest_px = 0.002;
  const Maps maps(fit, to_plane);
  const cv::Mat root = square_root(maps.covariance());
  const cv::Mat moves = displacements(maps, root, width_px, height_px);
  const cv::SVD principal(moves);
  std::vector<MapError> errors;
  for (int k = 0; k < principal.vt.rows; ++k) {
    const cv::Mat at_points = moves * principal.vt.row(k).t();
    double least = 0.0, most = 0.0;
    cv::minMaxLoc(cv::abs(at_points), &least, &most);
    if (most >= kSmallest_px) errors.push_back(error_of(maps, root * principal.vt.row(k).t()));
  }
  return errors;
}

using digitize::LensDistortion;
using digitize::PlaneMap;

double log_scale(const PlaneMap& to_board, cv::Point2d image_px) {
  const cv::Matx22d d = to_board.jacobian(image_px);
  return -0.5 * std::log(std::abs(d(0, 0) * d(1, 1) - d(0, 1) * d(1, 0)));
}

std::vector<cv::Point2d> places(const CalibrationSettings& settings) {
  std::vector<cv::Point2d> points;
  for (const double y : {0.1, 0.5, 0.9}) {
    for (const double x : {0.1, 0.5, 0.9}) {
      points.emplace_back(x * (settings.width_px - 1), y * (settings.height_px - 1));
    }
  }
  return points;
}

std::optional<std::string> too_poor(const Calibration& found, const cv::Mat& slopes,
                                    const CalibrationSettings& settings) {
  const double points = found.scale_errors.points, tolerance = settings.tolerance_share;
  if (points <= tolerance) return std::nullopt;
  const bool by_lens = scale_sd_share_of_known_lens(slopes, found.fit.covariance) <= tolerance;
  return fmt::format(
      "away from the board, which covers {:.0f} % of the photograph, the scale is uncertain by {:.2g} % "
      "(allowed are "
      "{:.2g} %): {}",
      100.0 * found.covered_share, 100.0 * points, 100.0 * tolerance,
      by_lens
          ? "the lens is not determined; add photographs with the board in the corners, or use a larger board"
          : "use a board that fills more of the photograph, or has more squares, in the balls' plane");
}

/// Board metres to plane px: at the photograph's centre x to the right, y up, a pixel a pixel.
cv::Matx33d similarity(const PlaneMap& to_board, const CalibrationSettings& settings, double px_per_m) {
  const cv::Point2d centre(0.5 * (settings.width_px - 1), 0.5 * (settings.height_px - 1));
  const cv::Matx22d d = to_board.jacobian(centre);
  // Rotation (or reflection) nearest to the derivative's inverse; image rows count downwards.
  const double sign = d(0, 0) * d(1, 1) - d(0, 1) * d(1, 0) > 0.0 ? 1.0 : -1.0;
  const double turn = std::atan2(d(1, 0) - sign * d(0, 1), d(0, 0) + sign * d(1, 1));
  const double c = px_per_m * std::cos(turn), s = px_per_m * std::sin(turn);
  const cv::Matx22d linear(c, s, sign * s, -sign * c);
  const cv::Point2d at = to_board.to_plane(centre);
  const cv::Vec2d moved = linear * cv::Vec2d(at.x, at.y);
  return {linear(0, 0), linear(0, 1), centre.x - moved[0],
          linear(1, 0), linear(1, 1), settings.height_px - 1.0 - centre.y - moved[1],
          0.0,          0.0,          1.0};
}

cv::Point2d transform(const cv::Matx33d& similarity_of, cv::Point2d p) {
  const cv::Vec3d q = similarity_of * cv::Vec3d(p.x, p.y, 1.0);
  return {q[0], q[1]};
}

double covered(const BoardView& view, const CalibrationSettings& settings) {
  const std::vector<cv::Point2f> points(view.image_px.begin(), view.image_px.end());
  std::vector<cv::Point2f> hull;
  cv::convexHull(points, hull);
  return cv::contourArea(hull) / (static_cast<double>(settings.width_px) * settings.height_px);
}

double largest_shift(const LensDistortion& lens, const CalibrationSettings& settings) {
  const PlaneMap map = PlaneMap::calibrated(lens, cv::Matx33d::eye(), {});
  double most = 0.0;
  for (const double x : {0.0, settings.width_px - 1.0}) {
    for (const double y : {0.0, settings.height_px - 1.0}) {
      most = std::max(most, cv::norm(map.to_plane({x, y}) - cv::Point2d(x, y)));
    }
  }
  return most;
}

void locate(const CalibrationSettings& settings, const cv::Matx33d& to_plane, Calibration& calibration) {
  const double sd = settings.lens_distance_sd_m.value_or(0.01 * settings.lens_distance_m.value_or(1.0));
  const auto pose = locate_lens(calibration.fit, settings.lens_distance_m, sd);
  if (!pose) return;
  LensPosition place;
  place.viewpoint = {transform(to_plane, pose->foot_m), pose->distance_m * calibration.px_per_m};
  place.distance_sd_px = pose->distance_sd_m * calibration.px_per_m;
  place.focal_px = pose->focal * calibration.lens.focal_px;
  place.tilt_rad = pose->tilt_rad;
  calibration.place = place;
  calibration.scale_errors.off_plane = settings.off_plane_sd_m / pose->distance_m;
}

void remark(const CalibrationSettings& settings, Calibration& calibration) {
  auto& remarks = calibration.remarks;
  if (calibration.covered_share < 0.3) {
    remarks.push_back(
        fmt::format("the board covers {:.0f} % of the photograph: outside of it the map is extrapolated, and "
                    "known less well",
                    100.0 * calibration.covered_share));
  }
  if (calibration.fit.rms_px > 0.3) {
    remarks.push_back(fmt::format("the board's points are {:.2f} px rms off: is it flat, sharp and still?",
                                  calibration.fit.rms_px));
  }
  if (calibration.fit.outliers > 0) {
    remarks.push_back(fmt::format("{} of the board's points were left out, more than 5 sigma off",
                                  calibration.fit.outliers));
  }
  if (!calibration.place) {
    remarks.push_back(
        "the photographs do not tell how far away the lens is: balls are taken to show as circles, and an "
        "error of the board's place is not in the scale's sd (add photographs of the slanted board, or give "
        "--lens-distance-m)");
  } else if (settings.lens_distance_m) {
    const double found = calibration.place->viewpoint.distance_px / calibration.px_per_m;
    const double sd = settings.lens_distance_sd_m.value_or(0.01 * *settings.lens_distance_m);
    if (std::abs(found - *settings.lens_distance_m) > 3.0 * sd) {
      remarks.push_back(fmt::format("the photographs say that the lens is {:.3f} m away, not {:.3f} m", found,
                                    *settings.lens_distance_m));
    }
  }
}

/// Noise makes two photographs of the same board differ by root two of its sd. A copy would be counted as a
/// measurement that it is not.
bool same_photograph(const BoardView& a, const BoardView& b, double sigma_px) {
  if (a.image_px.size() != b.image_px.size()) return false;
  double sum = 0.0;
  for (std::size_t i = 0; i < a.image_px.size(); ++i) {
    const cv::Point2d off = a.image_px[i] - b.image_px[i];
    sum += off.dot(off);
  }
  // Of 18 coordinates or more, chance makes so little but once in a million.
  const double rms_px =
      std::sqrt(sum / (2.0 * static_cast<double>(std::max<std::size_t>(a.image_px.size(), 1))));
  return rms_px <= std::numbers::sqrt2 * sigma_px / 3.0;
}

/// The fit of all photographs but those that are another's copy.
Result<BoardFit> fit_distinct(std::span<const BoardView> views, const CalibrationSettings& settings,
                              std::vector<std::string>& remarks) {
  auto fit = fit_boards(views, settings.width_px, settings.height_px);
  if (!fit) return fit;
  std::vector<BoardView> distinct;
  for (const BoardView& view : views) {
    const auto other = std::ranges::find_if(
        distinct, [&](const BoardView& before) { return same_photograph(before, view, fit->sigma_px); });
    if (other == distinct.end())
      distinct.push_back(view);
    else
      remarks.push_back(
          fmt::format("{} is the same photograph as {}: it was left out", view.name, other->name));
  }
  if (distinct.size() < views.size()) fit = fit_boards(distinct, settings.width_px, settings.height_px);
  return fit;
}

std::optional<std::string> wrong(const CalibrationSettings& s) {
  if (s.width_px < 16 || s.height_px < 16) return "the photograph is too small";
  if (!(s.spacing_sd_share >= 0.0 && s.spacing_sd_share <= 0.1)) return "the board's sd must be 0 to 10 %";
  if (!(s.off_plane_sd_m >= 0.0)) return "the sd of the board's place must not be negative";
  if (s.lens_distance_m && !(*s.lens_distance_m > 0.0)) return "the lens' distance must be above 0";
  if (s.lens_distance_sd_m && !(*s.lens_distance_sd_m > 0.0))
    return "the sd of the lens' distance must be above 0";
  if (!(s.tolerance_share > 0.0)) return "the tolerance must be above 0";
  return std::nullopt;
}

}  // namespace

PlaneMap board_map(const LensDistortion& lens, const cv::Matx33d& homography) {
  const double f = lens.focal_px;
  const cv::Matx33d normalize(1.0 / f, 0.0, -lens.centre_px.x / f, 0.0, 1.0 / f, -lens.centre_px.y / f, 0.0,
                              0.0, 1.0);
  return PlaneMap::calibrated(lens, homography.inv() * normalize, {});
}

cv::Mat scale_slopes(const BoardFit& fit, const CalibrationSettings& settings) {
  const auto where = places(settings);
  std::vector<double> x = fit.parameters;
  const int n = static_cast<int>(x.size());
  cv::Mat slopes(static_cast<int>(where.size()), n, CV_64F, cv::Scalar(0.0));
  for (int i = 0; i < n; ++i) {
    const double kept = x[static_cast<std::size_t>(i)];
    const double step = 0.01 * std::sqrt(std::max(fit.covariance.at<double>(i, i), 0.0)) + 1e-14;
    for (const double sign : {1.0, -1.0}) {
      x[static_cast<std::size_t>(i)] = kept + sign * step;
      const PlaneMap map = board_map(lens_of(fit, x), homography_of(x, 0));
      for (std::size_t p = 0; p < where.size(); ++p) {
        slopes.at<double>(static_cast<int>(p), i) += sign * log_scale(map, where[p]) * 0.5 / step;
      }
    }
    x[static_cast<std::size_t>(i)] = kept;
  }
  return slopes;
}

double scale_sd_share(const cv::Mat& slopes, const cv::Mat& covariance) {
  const cv::Mat spread = slopes * covariance * slopes.t();
  return std::sqrt(std::max(0.0, cv::trace(spread)[0]) / static_cast<double>(slopes.rows));
}

double scale_sd_share_of_known_lens(const cv::Mat& slopes, const cv::Mat& covariance) {
  const int terms = static_cast<int>(kLensPriorSds.size()), rest = covariance.rows - terms;
  const cv::Mat shared = covariance(cv::Rect(rest, 0, terms, rest));
  const cv::Mat lens = covariance(cv::Rect(rest, rest, terms, terms));
  const cv::Mat given_lens =
      covariance(cv::Rect(0, 0, rest, rest)) - shared * lens.inv(cv::DECOMP_SVD) * shared.t();
  return scale_sd_share(slopes.colRange(0, rest), given_lens);
}

double ScaleErrors::common() const { return std::hypot(print, off_plane.value_or(0.0)); }
double ScaleErrors::total() const { return std::hypot(points, common()); }

PlaneMap Calibration::map() const {
  return PlaneMap::calibrated(lens, rectify, place ? std::optional(place->viewpoint) : std::nullopt);
}

Result<Calibration> calibrate(std::span<const BoardView> views, const CalibrationSettings& settings) {
  if (const auto what = wrong(settings)) return fail(*what);
  Calibration calibration;
  auto fit = fit_distinct(views, settings, calibration.remarks);
  if (!fit) return tl::unexpected(fit.error());
  calibration.fit = std::move(*fit);
  calibration.lens = calibration.fit.lens;
  const PlaneMap to_board = board_map(calibration.lens, calibration.fit.homographies[0]);
  const cv::Point2d centre(0.5 * (settings.width_px - 1), 0.5 * (settings.height_px - 1));
  calibration.px_per_m = std::exp(log_scale(to_board, centre));
  if (!std::isfinite(calibration.px_per_m)) return fail("the boards fit no camera");
  const cv::Matx33d to_plane = similarity(to_board, settings, calibration.px_per_m);
  calibration.rectify = rectification(calibration.fit.homographies[0], calibration.lens, to_plane);
  calibration.map_errors = map_errors(calibration.fit, to_plane, settings.width_px, settings.height_px);
  const cv::Mat slopes = scale_slopes(calibration.fit, settings);
  calibration.scale_errors.points = scale_sd_share(slopes, calibration.fit.covariance);
  calibration.scale_errors.print = settings.spacing_sd_share;
  calibration.covered_share = covered(views[0], settings);
  calibration.largest_shift_px = largest_shift(calibration.lens, settings);
  calibration.too_poor = too_poor(calibration, slopes, settings);
  locate(settings, to_plane, calibration);
  remark(settings, calibration);
  return calibration;
}

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
