#include "host/camera/board_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/camera/lens_pose.hpp"

namespace strobe::camera {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
/// In diagonals of the photograph: 50 mm on 28 mm. What is assumed of a lens that nothing is known of.
constexpr double kUsualFocal = 1.8;

/// What placements are worked out from.
struct Planning {
  const BoardPattern& pattern;
  digitize::LensDistortion lens;
  cv::Size size_px;
  double focal_px = 0.0;
  double distance_m = 0.0;
  bool is_upright = false;  ///< the board's rows run down the photograph, as in the balls' plane
};

Planning planning_of(const Calibration& found, const BoardPattern& pattern,
                     const CalibrationSettings& settings) {
  Planning planning{pattern, found.lens, {settings.width_px, settings.height_px}};
  planning.focal_px = found.place ? found.place->focal_px : kUsualFocal * found.lens.focal_px;
  planning.distance_m =
      found.place ? found.place->viewpoint.distance_px / found.px_per_m : planning.focal_px / found.px_per_m;
  const cv::Matx33d& h = found.fit.homographies[0];
  planning.is_upright = std::abs(h(1, 0)) > std::abs(h(0, 0));
  return planning;
}

cv::Matx33d rotation(const BoardPlacement& placement, bool is_upright) {
  const bool sideways = placement.nearer == NearerSide::left || placement.nearer == NearerSide::right;
  const double sign =
      placement.nearer == NearerSide::right || placement.nearer == NearerSide::upper ? 1.0 : -1.0;
  const double c = std::cos(placement.slant_rad), s = sign * std::sin(placement.slant_rad);
  const cv::Matx33d slant =
      sideways ? cv::Matx33d(c, 0, s, 0, 1, 0, -s, 0, c) : cv::Matx33d(1, 0, 0, 0, c, -s, 0, s, c);
  return is_upright ? slant * cv::Matx33d(0, -1, 0, 1, 0, 0, 0, 0, 1) : slant;
}

/// Board metres to the normalized photograph, with the board's middle at a place of the photograph.
cv::Matx33d homography_at(const Planning& planning, const BoardPlacement& placement, cv::Point2d middle_px,
                          cv::Point2d middle_m) {
  const double z = planning.distance_m * placement.distance_share, unit = planning.lens.focal_px;
  const cv::Point2d aside = (middle_px - planning.lens.centre_px) * (z / planning.focal_px);
  const cv::Matx33d turn = rotation(placement, planning.is_upright);
  const cv::Vec3d shift = cv::Vec3d(aside.x, aside.y, z) - turn * cv::Vec3d(middle_m.x, middle_m.y, 0.0);
  const double f = planning.focal_px / unit;
  const cv::Matx33d h(f * turn(0, 0), f * turn(0, 1), f * shift[0], f * turn(1, 0), f * turn(1, 1),
                      f * shift[1], turn(2, 0), turn(2, 1), shift[2]);
  return h * (1.0 / h(2, 2));
}

/// Of the squares around the outermost points, which a detector needs.
std::array<cv::Point2d, 4> outline_m(const std::vector<cv::Point2d>& points, double spacing_m) {
  cv::Point2d low = points.front(), high = low;
  for (const cv::Point2d& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  low -= cv::Point2d(spacing_m, spacing_m);
  high += cv::Point2d(spacing_m, spacing_m);
  return {low, cv::Point2d(high.x, low.y), high, cv::Point2d(low.x, high.y)};
}

/// How far to go for an outline from `low` to `high` to touch its border, or to be in the middle.
double missing(int side, double low, double high, double size_px, double margin_px) {
  if (side < 0) return margin_px - low;
  if (side > 0) return size_px - 1.0 - margin_px - high;
  return 0.5 * (size_px - 1.0) - 0.5 * (low + high);
}

/// Returns nullopt if the board is not seen as a whole there.
std::optional<PlannedBoard> placed(const Planning& planning, const BoardPlacement& placement,
                                   const std::vector<cv::Point2d>& points) {
  constexpr int kSteps = 12;  // each leaves a tenth or less of what was missing
  const double margin_px = 0.015 * cv::norm(cv::Point(planning.size_px));
  const auto corners = outline_m(points, planning.pattern.spacing_m);
  const cv::Point2d middle_m = (corners[0] + corners[2]) * 0.5;
  PlannedBoard planned{placement, planning.lens.centre_px, {}, {}, 0.0};
  for (int step = 0; step < kSteps; ++step) {
    planned.homography = homography_at(planning, placement, planned.middle_px, middle_m);
    const auto map = board_map(planning.lens, planned.homography);
    planned.outline_px.clear();
    for (const cv::Point2d& corner : corners) planned.outline_px.push_back(map.to_image(corner));
    const auto [left, right] = std::ranges::minmax(planned.outline_px, {}, &cv::Point2d::x);
    const auto [top, bottom] = std::ranges::minmax(planned.outline_px, {}, &cv::Point2d::y);
    const double slack_px = 0.5 * margin_px;
    if (step == kSteps - 1 &&
        !(left.x > slack_px && top.y > slack_px && right.x < planning.size_px.width - 1.0 - slack_px &&
          bottom.y < planning.size_px.height - 1.0 - slack_px))
      return std::nullopt;
    if (step < kSteps - 1)
      planned.middle_px +=
          cv::Point2d(missing(placement.across, left.x, right.x, planning.size_px.width, margin_px),
                      missing(placement.down, top.y, bottom.y, planning.size_px.height, margin_px));
  }
  return planned;
}

std::vector<PlannedBoard> all_placements(const Planning& planning) {
  const auto points = board_points(planning.pattern);
  std::vector<PlannedBoard> found;
  for (const double distance_share : {1.0, 0.8, 1.25, 1.6}) {
    for (const double slant_deg : {20.0, 30.0}) {
      for (const auto nearer : {NearerSide::left, NearerSide::right, NearerSide::upper, NearerSide::lower}) {
        for (int place = 0; place < 9; ++place) {
          const BoardPlacement placement{place % 3 - 1, place / 3 - 1, distance_share, slant_deg * kDegree,
                                         nearer};
          if (auto planned = placed(planning, placement, points)) found.push_back(std::move(*planned));
        }
      }
    }
  }
  return found;
}

/// The scale's sd with each, given a fit; slopes are those of the first view's parameters and the lens'.
void judge(std::vector<PlannedBoard>& boards, const BoardFit& fit, const std::vector<cv::Point2d>& points,
           const CalibrationSettings& settings) {
  const cv::Mat slopes = scale_slopes(fit, settings);
  for (PlannedBoard& board : boards)
    board.scale_sd_share = scale_sd_share(slopes, covariance_with(fit, points, board.homography));
}

std::string_view name(NearerSide side) {
  switch (side) {
    case NearerSide::left:
      return "left";
    case NearerSide::right:
      return "right";
    case NearerSide::upper:
      return "upper";
    case NearerSide::lower:
      return "lower";
  }
  return "";
}

std::string place_name(int across, int down) {
  const char* vertical = down < 0 ? "upper" : "lower";
  const char* horizontal = across < 0 ? "left" : "right";
  if (across != 0 && down != 0) return fmt::format("in the {} {} corner", vertical, horizontal);
  if (across != 0) return fmt::format("at the {} border", horizontal);
  return down != 0 ? fmt::format("at the {} border", vertical) : "in the middle";
}

std::string polygon(const std::vector<cv::Point2d>& outline, double scale, const char* paint) {
  std::string points;
  for (const cv::Point2d& p : outline) points += fmt::format("{:.1f},{:.1f} ", scale * p.x, scale * p.y);
  return fmt::format("<polygon points=\"{}\" {}/>\n", points, paint);
}

}  // namespace

std::vector<PlannedBoard> rank_placements(const Calibration& found, const BoardPattern& pattern,
                                          const CalibrationSettings& settings) {
  auto boards = all_placements(planning_of(found, pattern, settings));
  judge(boards, found.fit, board_points(pattern), settings);
  std::ranges::stable_sort(boards, {}, &PlannedBoard::scale_sd_share);
  return boards;
}

BoardPlan plan_boards(const Calibration& found, const BoardPattern& pattern,
                      const CalibrationSettings& settings, int count) {
  const Planning planning = planning_of(found, pattern, settings);
  const auto points = board_points(pattern);
  const cv::Mat slopes = scale_slopes(found.fit, settings);
  BoardPlan plan;
  plan.scale_sd_share = found.scale_errors.points;
  plan.limit_share = scale_sd_share_of_known_lens(slopes, found.fit.covariance);
  plan.distance_m = planning.distance_m;
  plan.distance_known = found.place.has_value();
  if (found.place) plan.distance_sd_m = found.place->distance_sd_px / found.px_per_m;
  auto boards = all_placements(planning);
  BoardFit fit = found.fit;
  for (int i = 0; i < count && !boards.empty(); ++i) {
    judge(boards, fit, points, settings);
    const auto best = std::ranges::min_element(boards, {}, &PlannedBoard::scale_sd_share);
    fit = with_planned_view(fit, points, best->homography);
    plan.next.push_back(*best);
    boards.erase(best);  // another slant there may still come
  }
  const double tape_sd_m =
      settings.lens_distance_sd_m.value_or(0.01 * settings.lens_distance_m.value_or(1.0));
  if (const auto pose = locate_lens(fit, settings.lens_distance_m, tape_sd_m))
    plan.next_distance_sd_m = pose->distance_sd_m;
  return plan;
}

std::string describe(const BoardPlacement& placement) {
  const std::string distance =
      placement.distance_share == 1.0
          ? "as far as the balls' plane"
          : fmt::format("{:g} times as far as the balls' plane", placement.distance_share);
  return fmt::format("slanted by {:.0f} degrees, its {} side nearer, {}, {}", placement.slant_rad / kDegree,
                     name(placement.nearer), place_name(placement.across, placement.down), distance);
}

std::string plan_svg(const BoardPlan& plan, const Calibration& found, const BoardPattern& pattern,
                     const CalibrationSettings& settings) {
  constexpr double kWidth = 720.0;
  const double scale = kWidth / settings.width_px, height = scale * settings.height_px;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" font-family=\"sans-serif\">\n"
      "<title>The board's next photographs</title>\n"
      "<rect width=\"{:.0f}\" height=\"{:.0f}\" fill=\"#ffffff\" stroke=\"#222222\" stroke-width=\"2\"/>\n",
      kWidth, height, kWidth, height);
  const auto corners = outline_m(board_points(pattern), pattern.spacing_m);
  for (const cv::Matx33d& homography : found.fit.homographies) {
    const auto map = board_map(found.lens, homography);
    std::vector<cv::Point2d> seen;
    for (const cv::Point2d& corner : corners) seen.push_back(map.to_image(corner));
    out += polygon(seen, scale, "fill=\"none\" stroke=\"#222222\" stroke-dasharray=\"2 4\"");
  }
  for (std::size_t i = 0; i < plan.next.size(); ++i) {
    const PlannedBoard& board = plan.next[i];
    out += polygon(board.outline_px, scale,
                   "fill=\"#0072B2\" fill-opacity=\"0.1\" stroke=\"#0072B2\" stroke-width=\"2\"");
    out += fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\" font-size=\"22\" fill=\"#0072B2\">{}"
        "<title>{}</title></text>\n",
        scale * board.middle_px.x, scale * board.middle_px.y, i + 1, describe(board.placement));
  }
  return out + "</svg>\n";
}

}  // namespace strobe::camera
