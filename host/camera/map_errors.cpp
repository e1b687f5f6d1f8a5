#include "host/camera/map_errors.hpp"

#include <algorithm>
#include <cmath>

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

/// Columns: one sd of independent combinations of the parameters. By way of correlations, since the parameters' sizes
/// differ by many orders.
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

}  // namespace

cv::Matx33d rectification(const cv::Matx33d& homography, const digitize::LensDistortion& lens,
                          const cv::Matx33d& to_plane) {
  const double f = lens.focal_px;
  const cv::Point2d c = lens.centre_px;
  const cv::Matx33d normalize(1.0 / f, 0.0, -c.x / f, 0.0, 1.0 / f, -c.y / f, 0.0, 0.0, 1.0);
  const cv::Matx33d rectify = to_plane * homography.inv() * normalize;
  return rectify * (1.0 / rectify(2, 2));
}

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

}  // namespace strobe::camera
