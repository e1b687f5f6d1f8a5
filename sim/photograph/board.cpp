#include "sim/photograph/board.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "common/messages/parsed_json.hpp"
#include "common/units/angles.hpp"
#include "sim/photograph/appearance.hpp"
#include "sim/random/draws.hpp"
#include "sim/rig/camera.hpp"

namespace strobe::sim {
namespace {

constexpr double kDiscRadius = 0.22;  ///< of the spacing
constexpr double kBlack = 0.05, kWhite = 0.75;

cv::Matx33d turned(double angle_rad, int axis) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  if (axis == 0) return {1, 0, 0, 0, c, -s, 0, s, c};
  if (axis == 1) return {c, 0, s, 0, 1, 0, -s, 0, c};
  return {c, -s, 0, s, c, 0, 0, 0, 1};
}

cv::Point2d point_of(const Board& board, int column, int row) {
  const double step = 0.5 * board.spacing_m;
  if (board.print == BoardPrint::staggered) return {step * (2 * column + row % 2), step * row};
  return {board.spacing_m * column, board.spacing_m * row};
}

cv::Point2d middle(const Board& board) {
  const cv::Point2d last = point_of(board, board.columns - 1, board.rows - 1);
  const double stagger =
      board.print == BoardPrint::staggered && board.rows % 2 == 1 ? 0.5 * board.spacing_m : 0.0;
  return {0.5 * (last.x + stagger), 0.5 * last.y};
}

/// From (x, y, 1) on the board to the camera's axes: x right, y down, z away.
cv::Matx33d to_camera(const Board& board, const BoardPlace& place) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  const cv::Matx33d turn = turned(place.turns_deg[2] * kDegree, 2) * turned(place.turns_deg[1] * kDegree, 1) *
                           turned(place.turns_deg[0] * kDegree, 0);
  const cv::Point2d m = middle(board);
  const cv::Vec3d shift =
      cv::Vec3d(place.aside_m[0], place.aside_m[1], place.distance_m) - turn * cv::Vec3d(m.x, m.y, 0.0);
  return {turn(0, 0), turn(0, 1), shift[0],   turn(1, 0), turn(1, 1),
          shift[1],   turn(2, 0), turn(2, 1), shift[2]};
}

cv::Point2d lens_centre(const BoardCamera& camera) {
  return {0.5 * (camera.width_px - 1) + camera.lens_aside_px[0],
          0.5 * (camera.height_px - 1) + camera.lens_aside_px[1]};
}

cv::Point2d distorted(const std::array<double, 4>& lens, cv::Point2d p) {
  const double r2 = p.dot(p), radial = 1.0 + r2 * (lens[0] + r2 * lens[1]);
  return {p.x * radial + 2.0 * lens[2] * p.x * p.y + lens[3] * (r2 + 2.0 * p.x * p.x),
          p.y * radial + lens[2] * (r2 + 2.0 * p.y * p.y) + 2.0 * lens[3] * p.x * p.y};
}

/// (x/z, y/z) of a place of the photograph, by fixed-point iteration: a factor of ten a step for ordinary
/// lenses.
cv::Point2d ray_of(const BoardCamera& camera, cv::Point2d image_px) {
  const cv::Point2d seen = (image_px - lens_centre(camera)) * (1.0 / camera.focal_px);
  cv::Point2d p = seen;
  for (int i = 0; i < 12; ++i) p += seen - distorted(camera.lens, p);
  return p;
}

cv::Point2d divided(const cv::Vec3d& v) { return {v[0] / v[2], v[1] / v[2]}; }

bool black(const Board& board, cv::Point2d at) {
  const double s = board.spacing_m;
  if (board.print == BoardPrint::chessboard) {
    const double column = std::floor(at.x / s), row = std::floor(at.y / s);
    const bool on = column >= -1 && row >= -1 && column < board.columns && row < board.rows;
    return on && (static_cast<int>(column + row) & 1) == 0;
  }
  const double step = board.print == BoardPrint::staggered ? 0.5 * s : s;
  const int row = static_cast<int>(std::lround(at.y / step));
  const double offset = board.print == BoardPrint::staggered && (row & 1) ? 0.5 * s : 0.0;
  const int column = static_cast<int>(std::lround((at.x - offset) / s));
  if (row < 0 || row >= board.rows || column < 0 || column >= board.columns) return false;
  return cv::norm(at - point_of(board, column, row)) < kDiscRadius * s;
}

/// Share of white over a pixel from the board's places at its corners; straight between them.
double whiteness(const Board& board, const cv::Point2d (&corner)[4]) {
  const bool first = black(board, corner[0]);
  const cv::Point2d centre = (corner[0] + corner[1] + corner[2] + corner[3]) * 0.25;
  bool same = black(board, centre) == first;
  for (int i = 1; i < 4; ++i) same = same && black(board, corner[i]) == first;
  if (same) return first ? 0.0 : 1.0;
  // A Fibonacci lattice: an edge along the rows or columns would meet a square one's points a whole row at a
  // time.
  constexpr int kSamples = 233, kStep = 144;
  int white = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double u = (i + 0.5) / kSamples, v = (i * kStep % kSamples + 0.5) / kSamples;
    const cv::Point2d at =
        (corner[0] * (1 - u) + corner[1] * u) * (1 - v) + (corner[2] * (1 - u) + corner[3] * u) * v;
    white += black(board, at) ? 0 : 1;
  }
  return static_cast<double>(white) / kSamples;
}

cv::Mat light_of(const BoardCamera& camera, const Board& board, const cv::Matx33d& to_board) {
  const int across = camera.width_px + 1;
  std::vector<cv::Point2d> above(static_cast<std::size_t>(across)), below = above;
  const auto row_of_corners = [&](int row, std::vector<cv::Point2d>& into) {
    for (int col = 0; col < across; ++col) {
      const cv::Point2d ray = ray_of(camera, {col - 0.5, row - 0.5});
      into[static_cast<std::size_t>(col)] = divided(to_board * cv::Vec3d(ray.x, ray.y, 1.0));
    }
  };
  cv::Mat light(camera.height_px, camera.width_px, CV_32FC1);
  row_of_corners(0, above);
  for (int row = 0; row < camera.height_px; ++row) {
    row_of_corners(row + 1, below);
    for (std::size_t col = 0; col + 1 < above.size(); ++col) {
      const cv::Point2d corner[4] = {above[col], above[col + 1], below[col], below[col + 1]};
      light.at<float>(row, static_cast<int>(col)) =
          static_cast<float>(kBlack + (kWhite - kBlack) * whiteness(board, corner));
    }
    std::swap(above, below);
  }
  return light;
}

/// Half of the noise's variance at white is the light's own.
void add_noise(cv::Mat& light, double sd, std::uint64_t seed) {
  Draws draws(seed, Purpose::appearance, 0);
  for (float* p = light.ptr<float>(); p < light.ptr<float>() + light.total(); ++p)
    *p += static_cast<float>(sd * std::sqrt(0.5 + 0.5 * std::max(0.0F, *p)) * draws.normal());
}

constexpr double kFar_m = 100.0;
/// The board as the turned camera has it before itself: x right, y down.
void turn(const Slant& slant, BoardView& view) {
  const Eigen::Vector3d down(1.0, -1.0, 1.0);
  const Eigen::Matrix3d r = down.asDiagonal() * slant.rotation() * down.asDiagonal();
  const Eigen::Vector3d middle =
      r * Eigen::Vector3d(view.place.aside_m[0], view.place.aside_m[1], view.place.distance_m);
  view.place.aside_m = {middle.x(), middle.y()};
  view.place.distance_m = middle.z();
  // Of a turn about x, then y, then z.
  view.place.turns_deg = {degrees(std::atan2(r(2, 1), r(2, 2))), -degrees(std::asin(r(2, 0))),
                          degrees(std::atan2(r(1, 0), r(0, 0)))};
  view.camera.lens_aside_px[0] += slant.shift_px().x();
  view.camera.lens_aside_px[1] -= slant.shift_px().y();
}

}  // namespace

cv::Point2d image_of(const BoardCamera& camera, const Board& board, const BoardPlace& place,
                     cv::Point2d board_m) {
  const cv::Point2d p = divided(to_camera(board, place) * cv::Vec3d(board_m.x, board_m.y, 1.0));
  return lens_centre(camera) + distorted(camera.lens, p) * camera.focal_px;
}

cv::Point2d board_at(const BoardCamera& camera, const Board& board, const BoardPlace& place,
                     cv::Point2d image_px) {
  const cv::Point2d ray = ray_of(camera, image_px);
  return divided(to_camera(board, place).inv() * cv::Vec3d(ray.x, ray.y, 1.0));
}

BoardPhotograph photograph_board(const BoardCamera& camera, const Board& board, const BoardPlace& place,
                                 std::uint64_t seed) {
  BoardPhotograph photograph;
  cv::Mat light = light_of(camera, board, to_camera(board, place).inv());
  if (camera.blur_px > 0.0) cv::GaussianBlur(light, light, {0, 0}, camera.blur_px);
  add_noise(light, camera.noise, seed);
  light.convertTo(photograph.pixels, camera.bits == 8 ? CV_8U : CV_16U, camera.bits == 8 ? 255.0 : 65535.0);
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      photograph.board_m.push_back(point_of(board, column, row));
      photograph.image_px.push_back(image_of(camera, board, place, photograph.board_m.back()));
    }
  }
  return photograph;
}

std::string board_truth_json(const BoardCamera& camera, const Board& board, const BoardPlace& place,
                             const BoardPhotograph& photograph, const std::string& file) {
  nlohmann::ordered_json truth;
  truth["photograph"] = file;
  truth["width_px"] = camera.width_px;
  truth["height_px"] = camera.height_px;
  truth["focal_px"] = camera.focal_px;
  truth["lens_distortion"] = camera.lens;
  truth["lens_centre_px"] = {lens_centre(camera).x, lens_centre(camera).y};
  truth["spacing_m"] = board.spacing_m;
  truth["distance_m"] = place.distance_m;
  truth["aside_m"] = place.aside_m;
  truth["turns_deg"] = place.turns_deg;
  for (std::size_t i = 0; i < photograph.board_m.size(); ++i) {
    truth["points"].push_back({{"board_m", {photograph.board_m[i].x, photograph.board_m[i].y}},
                               {"image_px", {photograph.image_px[i].x, photograph.image_px[i].y}}});
  }
  return messages::json_text(truth);
}

BoardView board_view(const Scene& scene) {
  const Optics optics(scene);
  const CameraSettings& from = scene.camera;
  const double distance_m = optics.perspective() ? optics.distance_m() : kFar_m;
  const double corner_m2 = from.half_width_m * from.half_width_m + 0.25 * from.height_m * from.height_m;
  const Vec2 foot = optics.image_of({0.0, 0.0, 0.0});
  BoardView view;
  view.camera.width_px = optics.sensor().width;
  view.camera.height_px = optics.sensor().height;
  view.camera.focal_px = optics.px_per_m() * distance_m;
  // The scene's is of the distance in the plane, in half diagonals of the view; OpenCV's of the tangent.
  view.camera.lens = {from.distortion * distance_m * distance_m / corner_m2, 0.0, 0.0, 0.0};
  view.camera.lens_aside_px = {foot.x - 0.5 * (view.camera.width_px - 1),
                               foot.y - 0.5 * (view.camera.height_px - 1)};
  view.place.distance_m = distance_m;
  view.place.aside_m = {-view.camera.lens_aside_px[0] / optics.px_per_m(),
                        -view.camera.lens_aside_px[1] / optics.px_per_m()};
  if (from.turned()) turn(Slant(from.swing_rad, from.tilt_rad, view.camera.focal_px), view);
  return view;
}

}  // namespace strobe::sim
