#include "host/digitize/surface/surface_line.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "host/digitize/core/ball.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/surface/edge_line.hpp"
#include "host/digitize/surface/edge_refinement.hpp"

namespace strobe::digitize {
namespace {

constexpr std::size_t kMaxLines = 12;
constexpr double kMinVisibleShare = 0.35;  // of what is not hidden
// Nearer than this, two edges are the two sides of a rounded one.
constexpr double kMinApart_px = 2.0 * kInlier_px;
// How much the distance of a plate's two edges changes towards its ends, by perspective; how much of the
// longer one's length the shorter has.
constexpr double kParallel = 0.25;
constexpr double kAsLong = 0.6;
// Of the clearer edge's contrast: fainter ones are the background's.
constexpr double kAsClear = 0.05;
constexpr double kMaxReach = 3.0;  ///< of the half length seen
// Of rigs: a plate in the middle of which balls are to bounce is no less deep than they are wide on either
// side.
constexpr double kDepthOfDiameter = 2.0;
constexpr double kOccludedRadii = 1.08;
constexpr double kMaxCirclesBelow = 0.5;
// Of outlines that no surface at the line allows, one in so many may be false, e.g. a clamp's. One of fewer
// is too much of what tells where the surface can be.
constexpr std::size_t kOutlinesPerFalse = 8;

/// Where balls cover the plate's edge.
OcclusionMask occlusion_of(const Photograph& photograph, const PlaneMap& map,
                           std::span<const Outline> outlines) {
  OcclusionMask occluded;
  occluded.mask = cv::Mat::zeros(hough_image_size(photograph.intensity.size()), CV_8UC1);
  occluded.scale = static_cast<double>(photograph.width()) / occluded.mask.cols;
  for (const Outline& o : outlines) {
    const cv::Point2d centre = map.to_image(o.centre);
    const cv::Point2d side = map.to_image(o.centre + cv::Point2d(0.5 * o.diameter, 0.0));
    const double radius = kOccludedRadii * cv::norm(side - centre);
    if (!(std::abs(centre.x) < 1e6 && std::abs(centre.y) < 1e6 && radius < 1e5)) continue;
    const auto coarse = [&](double at) { return cvRound((at + 0.5) / occluded.scale - 0.5); };
    cv::circle(occluded.mask, cv::Point(coarse(centre.x), coarse(centre.y)),
               static_cast<int>(std::ceil(radius / occluded.scale)), cv::Scalar(255), -1);
  }
  return occluded;
}

/// Whether the ball would be compressed by no more than a ball can be.
bool is_over(const Outline& o, const EdgeLine& edge) {
  return o.centre.y - edge.at(o.centre.x) > (1.0 - kMaxCompressionOfRadius) * 0.5 * o.diameter;
}

/// The outlines that the surface allows, if the others are few enough to be false; else all.
std::vector<Outline> balls_over(const EdgeLine& edge, std::span<const Outline> outlines) {
  std::vector<Outline> balls;
  std::ranges::copy_if(outlines, std::back_inserter(balls),
                       [&](const Outline& o) { return is_over(o, edge); });
  if (outlines.size() - balls.size() <= outlines.size() / kOutlinesPerFalse) return balls;
  return {outlines.begin(), outlines.end()};
}

/// How much of the outlines is visible below the line, in whole circles: nothing of a ball that the surface
/// flattens, but much of balls in front of a line above the surface, such as through the tops of two clamps.
double circles_below(const EdgeLine& edge, std::span<const Outline> outlines) {
  constexpr int kSteps = 180;
  double circles = 0.0;
  for (const Outline& o : outlines) {
    const double radius = 0.5 * o.diameter;
    const double allowed = kDoubtful_sd * o.blur_px;  // what is pressed flat there
    const double deepest = edge.at(o.centre.x) - o.centre.y + radius * std::hypot(1.0, edge.slope);
    if (deepest <= allowed) continue;  // no arc of it is
    for (const Arc& arc : o.visible_arcs) {
      const int steps = std::max(1, cvRound(arc.extent_rad / (2.0 * std::numbers::pi) * kSteps));
      for (int k = 0; k < steps; ++k) {
        const double angle = arc.from_rad + (k + 0.5) / steps * arc.extent_rad;
        const cv::Point2d at = o.centre + radius * cv::Point2d(std::cos(angle), std::sin(angle));
        if (edge.at(at.x) - at.y > allowed) circles += 1.0 / kSteps;
      }
    }
  }
  return circles;
}

bool possible(const EdgeLine& edge, std::span<const Outline> outlines) {
  const std::vector<Outline> balls = balls_over(edge, outlines);
  const bool below = std::ranges::all_of(balls, [&](const Outline& o) { return is_over(o, edge); });
  return below && circles_below(edge, balls) <= kMaxCirclesBelow;
}

/// Height of the lowest centre over the line, in radii.
double lowest(const EdgeLine& edge, std::span<const Outline> outlines) {
  double least = 1e300;
  for (const Outline& o : outlines)
    least = std::min(least, (o.centre.y - edge.at(o.centre.x)) / (0.5 * o.diameter));
  return least;
}

/// Long, clear and just below the lowest ball.
double quality(const EdgeLine& edge, std::span<const Outline> outlines) {
  double value = edge.visible_fraction * std::min(1.0, edge.contrast / 0.05);
  value /= 1.0 + 10.0 * circles_below(edge, outlines);
  if (!outlines.empty()) value /= 1.0 + 0.1 * std::max(0.0, lowest(edge, outlines) - 1.0);
  return value;
}

double largest_diameter(std::span<const Outline> outlines) {
  double diameter = 0.0;
  for (const Outline& o : outlines) diameter = std::max(diameter, o.diameter);
  return diameter;
}

/// The other edge of a plate that is seen from above: parallel to it, as long, and less than a ball away.
/// Kept though no scene shows one, because a camera a hand above the plate does, and heights would be wrong
/// by half its depth.
const EdgeLine* other_edge(const EdgeLine& edge, std::span<const EdgeLine> edges,
                           std::span<const Outline> outlines) {
  const double diameter = largest_diameter(outlines);
  const EdgeLine* other = nullptr;
  for (const EdgeLine& e : edges) {
    const double apart = std::abs(e.at(edge.middle.x) - edge.middle.y);
    if (apart < kMinApart_px || apart > diameter) continue;
    const double ends = std::abs(e.slope - edge.slope) * edge.half_span;
    if (ends > kParallel * apart || e.half_span < kAsLong * edge.half_span) continue;
    if (e.contrast < kAsClear * edge.contrast) continue;
    if (other == nullptr || e.visible_px > other->visible_px) other = &e;
  }
  return other;
}

/// Sd of what the lowest points of all balls are off on the average: heights over the surface are, too.
double lowest_sd_px(std::span<const Outline> outlines) {
  std::vector<double> variances, shared;
  const cv::Vec3d lowest_by(0.0, 1.0, -0.5);
  for (const Outline& o : outlines) {
    const double alike = 0.5 * o.shared_diameter_sd_px;
    variances.push_back(std::max(0.0, lowest_by.dot(o.covariance * lowest_by) - alike * alike));
    shared.push_back(alike);
  }
  const double count = std::max(1.0, static_cast<double>(outlines.size()));
  return std::hypot(upper_median(std::move(shared)), std::sqrt(upper_median(std::move(variances)) / count));
}

/// How far light saturates below the edge, at most `reach_px`: the median of what is seen of it.
double saturated_below_px(const Photograph& photograph, const PlaneMap& map, const OcclusionMask& occluded,
                          const EdgeLine& edge, double reach_px) {
  const double full = kSaturatedShare * static_cast<double>(photograph.saturation);
  const cv::Rect view(0, 0, photograph.width(), photograph.height());
  // Blur leaves the edge itself less than full.
  constexpr int kBlurred_px = 4;
  std::vector<double> depths;
  for (int i = 0; i < profile_count(photograph); ++i) {
    const double x = map.to_plane({static_cast<double>(profile_column(photograph, i)), 0.0}).x;
    double deep = 0.0;
    for (int below = kBlurred_px; below <= reach_px; ++below) {
      const cv::Point at(map.to_image({x, edge.at(x) - below}));
      if (at.x >= 0 && at.x < view.width && !view.contains(at)) {
        deep = reach_px;  // where it ends is not seen
        break;
      }
      if (!view.contains(at) || occluded.at(at.x, at.y)) {
        deep = -1.0;
        break;
      }
      if (photograph.intensity.at<float>(at) < full) break;
      deep = below;
    }
    if (deep >= 0.0) depths.push_back(deep);
  }
  return depths.empty() ? 0.0 : upper_median(std::move(depths));
}

/// From a lens above the plate: how far below its far edge its near one may be seen, and saturated light
/// hides it.
double hidden_below_px(const Photograph& photograph, const PlaneMap& map, const OcclusionMask& occluded,
                       const EdgeLine& edge, std::span<const Outline> outlines) {
  if (!map.viewpoint()) return 0.0;
  const double above = map.viewpoint()->foot_px.y - edge.at(map.viewpoint()->foot_px.x);
  const double reach = kDepthOfDiameter * largest_diameter(outlines) * above / map.viewpoint()->distance_px;
  const double hidden = saturated_below_px(photograph, map, occluded, edge, reach);
  return hidden < kMinApart_px ? 0.0 : hidden;
}

/// Half-way between the two, with the variance of a uniform distribution between them.
EdgeLine between(const EdgeLine& a, const EdgeLine& b) {
  EdgeLine line = a;
  const double apart = std::abs(b.at(a.middle.x) - a.middle.y);
  line.middle.y = 0.5 * (a.middle.y + b.at(a.middle.x));
  line.slope = 0.5 * (a.slope + b.slope);
  line.sd_px = std::hypot(apart / std::sqrt(12.0), std::max(a.sd_px, b.sd_px));
  line.slope_sd = std::hypot(std::max(a.slope_sd, b.slope_sd), (a.slope - b.slope) / std::sqrt(12.0));
  return line;
}

/// Four points on the line that, with an independent error of sd_px each, have its uncertainty of height and
/// slope.
SurfaceLine four_points(const EdgeLine& edge) {
  SurfaceLine line;
  const double reach = edge.sd_px / std::max(edge.slope_sd, 1e-12) * std::sqrt(1.8);
  const double a = std::min(std::max(reach, 1.0), std::max(1.0, kMaxReach * edge.half_span));
  for (const double share : {-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0}) {
    const double x = edge.middle.x + share * a;
    line.points.emplace_back(x, edge.at(x));
  }
  line.sd_px = 2.0 * edge.sd_px;
  return line;
}

/// Half-way to an edge that may be anywhere down to there.
SurfaceLine with_hidden_edge(const EdgeLine& edge, double hidden_px) {
  EdgeLine lowest = edge;
  lowest.middle.y -= hidden_px;
  SurfaceLine line = four_points(between(edge, lowest));
  line.hidden_px = hidden_px;
  return line;
}

}  // namespace

geometry::SurfaceFrame surface_frame(const SurfaceLine& line) {
  std::vector<Eigen::Vector2d> points;
  for (const cv::Point2d& p : line.points) points.push_back(to_eigen(p));
  geometry::SurfaceFrame frame;
  frame.line.reference = points.front();
  if (const auto fitted = geometry::fit_line(points)) frame.line = *fitted;
  return frame;
}

double height_sd_px(const SurfaceLine& line) {
  return line.sd_px / std::sqrt(std::max(1.0, static_cast<double>(line.points.size()) - 1.0));
}

Measured<SurfaceLine> find_surface_line(const Photograph& photograph, const PlaneMap& map,
                                        std::span<const Outline> outlines) {
  const OcclusionMask occluded = occlusion_of(photograph, map, outlines);
  const std::vector<HoughLine> rough = hough_lines(photograph, occluded, kMaxLines);
  std::vector<std::optional<EdgeLine>> measured(rough.size());
  cv::parallel_for_(cv::Range(0, static_cast<int>(rough.size())), [&](const cv::Range& range) {
    for (auto i = static_cast<std::size_t>(range.start); i < static_cast<std::size_t>(range.end); ++i)
      measured[i] = fit_edge_line(photograph, map, occluded, rough[i]);
  });
  std::vector<EdgeLine> edges;
  std::optional<EdgeLine> chosen;
  double longest = 0.0, best_quality = 0.0;
  for (const auto& edge : measured) {
    if (!edge) continue;
    const bool allowed = possible(*edge, outlines);
    if (allowed) longest = std::max(longest, edge->visible_fraction);
    if (edge->visible_fraction < kMinVisibleShare) continue;
    edges.push_back(*edge);
    if (!allowed) continue;
    const double value = quality(*edge, outlines);
    if (value > best_quality) best_quality = value, chosen = edge;
  }
  if (!chosen) {
    return tl::unexpected(Rejection{
        Reason::no_plate,
        fmt::format("no straight edge with light below it: the best is seen over {:.0f} % of the width",
                    100.0 * longest)});
  }
  EdgeLine best = refine_edge_line(photograph, map, occluded, *chosen);
  best.sd_px = std::hypot(best.sd_px, lowest_sd_px(outlines));
  const EdgeLine* other = other_edge(best, edges, outlines);
  if (other == nullptr)
    return with_hidden_edge(best, hidden_below_px(photograph, map, occluded, best, outlines));
  const EdgeLine middle = between(best, *other);
  // The other edge is a clamp's above the plate if balls reach below the middle.
  if (!possible(middle, outlines)) return four_points(best);
  SurfaceLine line = four_points(middle);
  line.edge_separation_px = std::abs(other->at(best.middle.x) - best.middle.y);
  return line;
}

namespace {

constexpr double kMaxTopSdOfDiameter = 0.05;

}  // namespace

Measured<ContactImage> measure_contact(const Outline& outline, const SurfaceLine& surface) {
  const geometry::SurfaceFrame axes = surface_frame(surface);
  const cv::Point2d up = to_point(axes.line.tilt * Eigen::Vector2d::UnitY());
  const double radius = 0.5 * outline.diameter;
  ContactImage contact;
  contact.top = outline.centre + radius * up;
  const cv::Vec3d top_by(up.x, up.y, 0.5);
  contact.top_sd_px = std::sqrt(top_by.dot(outline.covariance * top_by));
  if (!(contact.top_sd_px <= kMaxTopSdOfDiameter * outline.diameter)) {
    return tl::unexpected(Rejection{
        Reason::imprecise, fmt::format("the top of the ball is known to {:.1f} px only", contact.top_sd_px)});
  }
  const double height = axes.from_image(to_eigen(outline.centre)).y();
  const double half2 = radius * radius - height * height;
  if (half2 <= 0.0) return contact;
  // The chord that the surface cuts off: (w/2)² = r² - h².
  const double half = std::sqrt(half2);
  const cv::Vec3d width_by(-2.0 * height / half * up.x, -2.0 * height / half * up.y, radius / half);
  const double surface_part = 2.0 * height / half * height_sd_px(surface);
  const double sd = std::sqrt(width_by.dot(outline.covariance * width_by) + surface_part * surface_part);
  // Where the surface cuts the outline at a grazing angle.
  if (!(kDoubtful_sd * sd <= 2.0 * half)) return contact;
  contact.width_px = 2.0 * half;
  contact.width_sd_px = sd;
  return contact;
}

}  // namespace strobe::digitize
