#include "tests/host/camera/pinhole.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace strobe::testing {
namespace {

cv::Matx33d turned(double angle, int axis) {
  const double c = std::cos(angle), s = std::sin(angle);
  if (axis == 0) return {1, 0, 0, 0, c, -s, 0, s, c};
  if (axis == 1) return {c, 0, s, 0, 1, 0, -s, 0, c};
  return {c, -s, 0, s, c, 0, 0, 0, 1};
}

cv::Point2d middle(const camera::BoardPattern& p) {
  if (p.kind == camera::BoardKind::staggered_circles)
    return {0.5 * p.spacing_m * (p.columns - 0.5), 0.25 * p.spacing_m * (p.rows - 1)};
  return {0.5 * p.spacing_m * (p.columns - 1), 0.5 * p.spacing_m * (p.rows - 1)};
}

cv::Point2d place(const camera::BoardPattern& p, int column, int row) {
  const double step = 0.5 * p.spacing_m;
  if (p.kind == camera::BoardKind::staggered_circles) return {step * (2 * column + row % 2), step * row};
  return {p.spacing_m * column, p.spacing_m * row};
}

bool black(const camera::BoardPattern& p, cv::Point2d at) {
  if (p.kind == camera::BoardKind::chessboard) {
    const double column = std::floor(at.x / p.spacing_m), row = std::floor(at.y / p.spacing_m);
    const bool on = column >= -1 && row >= -1 && column < p.columns && row < p.rows;
    return on && (static_cast<int>(column + row) & 1) == 0;
  }
  for (int row = 0; row < p.rows; ++row) {
    for (int column = 0; column < p.columns; ++column)
      if (cv::norm(at - place(p, column, row)) < 0.22 * p.spacing_m) return true;
  }
  return false;
}

}  // namespace

cv::Point2d Pinhole::project(cv::Vec3d in_camera) const {
  const double x = in_camera[0] / in_camera[2], y = in_camera[1] / in_camera[2], r2 = x * x + y * y;
  const double bend = 1.0 + k1 * r2 + k2 * r2 * r2;
  return centre + cv::Point2d(x, y) * (focal_px * bend);
}

cv::Point2d Pinhole::ray(cv::Point2d image_px) const {
  const cv::Point2d seen = (image_px - centre) * (1.0 / focal_px);
  cv::Point2d p = seen;
  for (int i = 0; i < 30; ++i) {
    const double r2 = p.dot(p);
    p = seen * (1.0 / (1.0 + k1 * r2 + k2 * r2 * r2));
  }
  return p;
}

cv::Vec3d Pose::to_camera(cv::Point2d board_m) const {
  return turn * cv::Vec3d(board_m.x, board_m.y, 0.0) + shift;
}

cv::Point2d Pose::foot_m() const {
  const cv::Vec3d lens = turn.t() * shift * -1.0;
  return {lens[0], lens[1]};
}

double Pose::distance_m() const { return std::abs((turn.t() * shift)[2]); }

Pose pose(const camera::BoardPattern& pattern, double distance_m, cv::Vec3d turns_rad, cv::Point2d aside_m) {
  Pose result;
  result.turn = turned(turns_rad[2], 2) * turned(turns_rad[1], 1) * turned(turns_rad[0], 0);
  const cv::Point2d m = middle(pattern);
  result.shift = cv::Vec3d(aside_m.x, aside_m.y, distance_m) - result.turn * cv::Vec3d(m.x, m.y, 0.0);
  return result;
}

camera::BoardView view(const Pinhole& camera, const Pose& pose, const camera::BoardPattern& pattern,
                       double noise_px, std::mt19937_64& random) {
  std::normal_distribution<double> noise(0.0, noise_px);
  camera::BoardView result;
  result.name = "board";
  for (int row = 0; row < pattern.rows; ++row) {
    for (int column = 0; column < pattern.columns; ++column) {
      result.board_m.push_back(place(pattern, column, row));
      const cv::Point2d seen = camera.project(pose.to_camera(result.board_m.back()));
      const double dx = noise(random), dy = noise(random);
      result.image_px.emplace_back(seen.x + dx, seen.y + dy);
    }
  }
  return result;
}

cv::Mat photograph(const Pinhole& camera, const Pose& pose, const camera::BoardPattern& pattern, double noise,
                   std::mt19937_64& random) {
  const cv::Matx33d to_camera(pose.turn(0, 0), pose.turn(0, 1), pose.shift[0], pose.turn(1, 0),
                              pose.turn(1, 1), pose.shift[1], pose.turn(2, 0), pose.turn(2, 1),
                              pose.shift[2]);
  const cv::Matx33d to_board = to_camera.inv();
  cv::Mat light(camera.height, camera.width, CV_32FC1);
  for (int row = 0; row < camera.height; ++row) {
    for (int col = 0; col < camera.width; ++col) {
      int whites = 0;
      for (int sub = 0; sub < 9; ++sub) {
        const cv::Point2d ray = camera.ray({col + (sub % 3 - 1) / 3.0, row + (sub / 3 - 1) / 3.0});
        const cv::Vec3d at = to_board * cv::Vec3d(ray.x, ray.y, 1.0);
        whites += black(pattern, {at[0] / at[2], at[1] / at[2]}) ? 0 : 1;
      }
      light.at<float>(row, col) = 0.1F + 0.6F * static_cast<float>(whites) / 9.0F;
    }
  }
  cv::GaussianBlur(light, light, {0, 0}, 0.8);
  std::normal_distribution<float> grain(0.0F, static_cast<float>(noise));
  for (float* p = light.ptr<float>(); p < light.ptr<float>() + light.total(); ++p) *p += grain(random);
  return light;
}

}  // namespace strobe::testing
