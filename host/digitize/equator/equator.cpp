#include "host/digitize/equator/equator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <numbers>

#include "host/digitize/core/statistics.hpp"
#include "host/digitize/equator/line_choice.hpp"

namespace strobe::digitize {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

struct Found : LineChoice {
  LineSearch search;
  TiltRange range = TiltRange::slight;
};

/// The photograph binned to one resolution.
struct Level {
  BinnedImage image;
  std::optional<ShapeGrid> shapes;
};

struct Scene {
  Effort effort = Effort::standard;
  Level coarse, fine;
  std::vector<Disc> discs;
  std::vector<Shading> shadings;
  std::vector<std::vector<std::size_t>> overlapping;
};

/// Neighbours whose lines are to be subtracted from a ball's image. If two balls have found one and the same
/// line, it is subtracted from the ball with the lower score only.
std::vector<std::size_t> line_neighbours(const Scene& scene, std::size_t k, const std::vector<Found>& found) {
  std::vector<std::size_t> result;
  for (const std::size_t other : scene.overlapping[k]) {
    if (!found[other].accepted) continue;
    if (found[k].accepted) {
      const EquatorLine &a = found[k].fit->line, &b = found[other].fit->line;
      const cv::Point2d middle =
          scene.discs[k].unit(scene.discs[other].centre_image.x, scene.discs[other].centre_image.y);
      const bool same = angle_between(a, b) < 5.0 * kDegree &&
                        std::abs(LineCoordinates(a).across(middle.x, middle.y)) < 0.1;
      if (same && found[k].score > found[other].score) continue;
    }
    result.push_back(other);
  }
  return result;
}

BallPixels pixels_of(const Scene& scene, const Level& level, std::size_t k, const std::vector<Found>& found) {
  const auto with_lines = line_neighbours(scene, k, found);
  std::vector<Neighbour> neighbours;
  for (const std::size_t other : scene.overlapping[k]) {
    Neighbour& neighbour = neighbours.emplace_back(Neighbour{other, {}});
    if (std::ranges::find(with_lines, other) != with_lines.end()) neighbour.line = found[other].fit->line;
  }
  return BallPixels(level.image, scene.discs, scene.shadings, k, neighbours);
}

/// Searches the line of one ball in all directions, with the lines of `others` subtracted.
void search(const Scene& scene, std::size_t k, const std::vector<Found>& others,
            const std::optional<TypicalLine>& typical, Found& found) {
  BallPixels pixels = pixels_of(scene, scene.coarse, k, others);
  found.search = search_line(pixels, scene.effort, found.range);
  static_cast<LineChoice&>(found) =
      choose_line(pixels, found.search, *scene.coarse.shapes, found.range, typical);
}

bool has_line_beside(const Scene& scene, std::size_t k, const std::vector<Found>& found) {
  return std::ranges::any_of(scene.overlapping[k], [&](std::size_t other) { return found[other].accepted; });
}

/// Pixels near a line, with the neighbours' lines subtracted.
struct Near {
  std::vector<LinePoint> points;
  LineProfile profile;
};

Near near_line(const Scene& scene, std::size_t k, const std::vector<Found>& found) {
  Near near;
  BallPixels pixels = pixels_of(scene, scene.fine, k, found);
  const EquatorLine& line = found[k].fit->line;
  near.points = points_near(pixels, line);
  near.profile.add(near.points, line);
  return near;
}

template <typename Visit>
void for_each_ball(const Scene& scene, const Visit& visit) {
  cv::parallel_for_(cv::Range(0, static_cast<int>(scene.discs.size())), [&](const cv::Range& range) {
    for (int k = range.start; k < range.end; ++k) {
      const auto ball = static_cast<std::size_t>(k);
      if (is_valid(scene.discs[ball]) && !scene.coarse.image.around(scene.discs[ball], 1.0).empty())
        visit(ball);
    }
  });
}

std::optional<LineFit> fit_fine(const Scene& scene, std::size_t k, std::span<const LinePoint> points,
                                const EquatorLine& start, const LineFitSettings& settings) {
  return fit_line(points, scene.discs[k].radius_image_px / scene.fine.image.stride, start, settings);
}

bool refine(const Scene& scene, std::size_t k, std::span<const LinePoint> points, const LineShape& shape,
            Found& found) {
  EquatorLine start = found.fit->line;
  start.shape = shape;
  const auto fit = fit_fine(scene, k, points, start,
                            line_fit_settings(scene.discs[k], found.range, start.tilt_rad, nullptr));
  if (!fit || check_line(*fit, true) || fit->line.contrast <= 0.5 * found.fit->line.contrast) return false;
  found.fit = fit;
  return true;
}

/// How far from a great circle the drawn line is, as the other images show it: to which side of an image's
/// line is not known.
struct CommonOffset {
  double offset = 0.0, sd = 0.0;  ///< radii
};

struct MeasuredOffset {
  double offset = 0.0, variance = 0.0;
};

/// Of the sizes of the offsets of all images but one. Returns nullopt if they tell none.
std::optional<CommonOffset> common_offset(std::span<const std::optional<MeasuredOffset>> offsets,
                                          std::size_t but) {
  constexpr std::size_t kMinOthers = 3;
  constexpr double kClear_sd = 5.0;  // below, a mean of sizes is one of noise
  double weights = 0.0, sum = 0.0;
  std::vector<MeasuredOffset> used;
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    if (k == but || !offsets[k]) continue;
    used.push_back(*offsets[k]);
    weights += 1.0 / used.back().variance;
    sum += std::abs(used.back().offset) / used.back().variance;
  }
  if (used.size() < kMinOthers) return std::nullopt;
  const double offset = sum / weights;
  double squares = 0.0;
  for (const MeasuredOffset& one : used) squares += std::pow(std::abs(one.offset) - offset, 2) / one.variance;
  // What is scattered by more than its noise is known no better than its scatter tells.
  const double excess = std::max(1.0, squares / static_cast<double>(used.size() - 1));
  const double sd = std::sqrt(excess / weights);
  if (offset < kClear_sd * std::sqrt(excess * static_cast<double>(used.size()) / weights))
    return std::nullopt;
  return CommonOffset{offset, sd};
}

/// A line without what the priors added, about 0 where they are of offset and tilt.
struct Unbiased {
  cv::Vec3d line;  ///< angle, offset, tilt
  cv::Matx33d variance;
};

/// Takes back the priors of which `weights` is a part of fit.prior. Returns nullopt if nothing else tells the
/// line.
std::optional<Unbiased> without_prior(const LineFit& fit, const cv::Matx33d& weights) {
  bool told = false;
  const cv::Matx33d information = fit.variance.inv(cv::DECOMP_CHOLESKY, &told) - weights;
  if (!told) return std::nullopt;
  const cv::Matx33d variance = information.inv(cv::DECOMP_CHOLESKY, &told);
  if (!told) return std::nullopt;
  const cv::Vec3d line(fit.line.angle_rad, fit.line.offset, fit.line.tilt_rad);
  return Unbiased{line + variance * (weights * line), variance};
}

/// Fits again with priors of offset and tilt from all images, as all show the same line: the angle of a line
/// of which one end is visible becomes more certain, and so does the tilt of a line that is on no great
/// circle.
void fit_with_common_priors(const Scene& scene, const std::vector<Near>& near, std::vector<Found>& found) {
  std::vector<double> sizes, tilts;
  std::vector<std::optional<MeasuredOffset>> offsets(found.size());
  std::vector<std::optional<Unbiased>> unbiased(found.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!found[k].accepted) continue;
    const LineFit& fit = *found[k].fit;
    sizes.push_back(std::abs(fit.line.offset));
    tilts.push_back(std::abs(fit.line.tilt_rad));
    unbiased[k] = without_prior(fit, fit.prior);
    if (unbiased[k])
      offsets[k] = MeasuredOffset{unbiased[k]->line[1], fit.scatter * unbiased[k]->variance(1, 1)};
  }
  constexpr std::size_t kMinBalls = 5;
  const bool known = sizes.size() >= kMinBalls;
  const double offset_sd = kSdOverMad * upper_median(sizes);
  const double tilt_sd = std::max(kSdOverMad * upper_median(tilts), 0.005);
  for_each_ball(scene, [&](std::size_t k) {
    if (!found[k].accepted) return;
    const LineFit& before = *found[k].fit;
    const Disc& disc = scene.discs[k];
    LineFitSettings settings = line_fit_settings(disc, found[k].range, before.line.tilt_rad, nullptr);
    const auto common = common_offset(offsets, k);
    if (!known && !common) return;
    if (common && offsets[k]) {
      // Which side is likely: the means of two normal distributions, and what not knowing it adds.
      const double side = std::tanh(offsets[k]->offset * common->offset / offsets[k]->variance);
      settings.offset = side * common->offset;
      settings.offset_sd =
          std::hypot(common->sd, common->offset * std::sqrt(1.0 - side * side), disc.centre_sd);
    } else if (known) {
      settings.offset_sd = std::min(settings.offset_sd, std::hypot(offset_sd, disc.centre_sd));
    }
    const bool tilted =
        unbiased[k] && std::abs(unbiased[k]->line[2]) >
                           kFarthest_sd * std::sqrt(before.scatter * unbiased[k]->variance(2, 2));
    if (known && !tilted) settings.tilt_sd = std::min(settings.tilt_sd, tilt_sd);
    const auto fit = fit_fine(scene, k, near[k].points, before.line, settings);
    if (fit) found[k].fit = fit;
  });
}

/// Returns nullopt if most balls have no line.
std::optional<TypicalLine> typical_line(const std::vector<Found>& found) {
  std::vector<double> contrasts, widths;
  std::size_t searched = 0;
  for (const Found& one : found) {
    if (one.search.visible >= 0.7) ++searched;
    if (!one.accepted) continue;
    contrasts.push_back(one.fit->line.contrast);
    widths.push_back(one.fit->line.shape.spread());
  }
  if (contrasts.size() < 2 || 2 * contrasts.size() < searched) return std::nullopt;
  return TypicalLine{upper_median(contrasts), upper_median(widths)};
}

/// Rejects all lines if they are on a minority of the balls and none is clear, or on a few, however clear:
/// chance.
void reject_few(std::vector<Found>& found) {
  constexpr double kClear = 8.0;
  std::size_t searched = 0, accepted = 0, clear = 0;
  for (const Found& one : found) {
    if (one.search.visible >= 0.7) ++searched;
    if (one.accepted) ++accepted;
    if (one.accepted && one.score >= kClear) ++clear;
  }
  if (searched < 3 || 2 * accepted > searched || (clear > 0 && 4 * accepted >= searched)) return;
  for (Found& one : found) {
    if (!one.accepted) continue;
    one.accepted = false;
    one.why = {Reason::no_line, fmt::format("weak, and on {} of {} balls only", accepted, searched)};
  }
}

/// Over all balls, as one ball has few segments.
struct Scatter {
  double typical = 0.0;      ///< variance of the segments' offsets over that expected from their pixels
  double correlation = 1.0;  ///< factor of the variance by correlated neighbours
};

Scatter common_scatter(const std::vector<Found>& found) {
  double sum = 0.0, degrees_of_freedom = 0.0, products = 0.0;
  std::vector<double> ratios;
  for (const Found& one : found) {
    if (!one.accepted) continue;
    const double per = 1.0 / one.fit->expected_scatter;
    sum += one.fit->degrees_of_freedom * one.fit->scatter * per;
    products += one.fit->degrees_of_freedom * one.fit->covariance * per;
    degrees_of_freedom += one.fit->degrees_of_freedom;
    ratios.push_back(one.fit->scatter * per);
  }
  Scatter scatter;
  if (degrees_of_freedom <= 0.0 || sum <= 0.0) return scatter;
  scatter.typical = upper_median(ratios);
  scatter.correlation = std::clamp(1.0 + 2.0 * products / sum, 1.0, 2.5);
  return scatter;
}

/// As the image alone tells it, for that the tilts are alike tells nothing of a spin that changes them.
/// `factor`: of the fit's variances.
std::optional<Equator::Tilt> tilt_of(const LineFit& fit, double factor, double angle_sd_rad,
                                     double floor_rad) {
  constexpr double kMaxSd_rad = 10.0 * kDegree;  // beyond, the fit is not linear
  const auto free = without_prior(fit, cv::Matx33d::diag({0.0, 0.0, fit.prior(2, 2)}));
  if (!free || std::abs(free->line[2]) > kMaxTilt_rad) return std::nullopt;
  Equator::Tilt tilt;
  tilt.tilt_rad = free->line[2];
  tilt.sd_rad = std::hypot(std::sqrt(factor * free->variance(2, 2)), floor_rad);
  if (!(tilt.sd_rad < kMaxSd_rad)) return std::nullopt;
  tilt.correlation = std::clamp(factor * fit.variance(0, 2) / (angle_sd_rad * tilt.sd_rad), -0.999, 0.999);
  return tilt;
}

Measured<Equator> result(const Scene& scene, std::size_t k, const Found& found, const Scatter& scatter) {
  const Disc& disc = scene.discs[k];
  if (!found.accepted) return tl::unexpected<Rejection>(found.why);
  constexpr double kPriorDegrees = 12.0;
  const LineFit& fit = *found.fit;
  const double own = fit.scatter, all = scatter.typical * fit.expected_scatter;
  const double variance =
      (fit.degrees_of_freedom * own + kPriorDegrees * all) / (fit.degrees_of_freedom + kPriorDegrees);
  Equator equator;
  // A fiftieth of a pixel at the outline: shading residuals without any noise.
  const double floor_rad = std::max(0.01 * kDegree, 0.02 / disc.radius_image_px);
  // Others' light is misfitted below their limbs: of equators all along them errors have twice the variance.
  const double by_limbs = 1.0 + beside_limbs(fit.line, disc, scene.discs, scene.overlapping[k]);
  const double factor = by_limbs * variance * scatter.correlation;
  equator.sd_rad =
      std::hypot(std::sqrt(std::max(factor * fit.variance(0, 0), by_limbs * fit.angle_variance)), floor_rad);
  if (!(equator.sd_rad < 3.0 * kDegree))
    return tl::unexpected<Rejection>(
        Rejection{Reason::imprecise, fmt::format("sd of {:.1f} degrees", equator.sd_rad / kDegree)});
  const cv::Vec2d along =
      disc.plane_from_unit * cv::Vec2d(std::cos(fit.line.angle_rad), std::sin(fit.line.angle_rad));
  equator.angle_rad = std::atan2(along[1], along[0]);
  equator.tilt = tilt_of(fit, factor, equator.sd_rad, floor_rad);
  const bool reversed = equator.angle_rad < 0.0 || equator.angle_rad >= std::numbers::pi;
  if (reversed) equator.angle_rad += equator.angle_rad < 0.0 ? std::numbers::pi : -std::numbers::pi;
  if (equator.angle_rad >= std::numbers::pi) equator.angle_rad = 0.0;
  if (reversed && equator.tilt) {
    equator.tilt->tilt_rad *= -1.0;
    equator.tilt->correlation *= -1.0;
  }
  equator.contrast = std::min(1.0, fit.line.contrast);
  return equator;
}

Scene prepare(const Photograph& photograph, const PlaneMap& map, std::span<const Outline> outlines,
              Effort effort) {
  Scene scene;
  scene.effort = effort;
  std::vector<double> radii;
  std::vector<Disc> good;
  for (const Outline& outline : outlines) {
    scene.discs.push_back(make_disc(map, outline));
    if (!is_valid(scene.discs.back())) continue;
    good.push_back(scene.discs.back());
    radii.push_back(scene.discs.back().radius_image_px);
  }
  scene.overlapping.resize(scene.discs.size());
  scene.shadings.resize(scene.discs.size());
  if (good.empty()) return scene;
  const double radius = upper_median(radii);
  const bool fast = effort == Effort::fast;
  const auto level = [&](double wanted) {
    const int stride = std::max(1, static_cast<int>(radius / wanted));
    Level result{bin_image(photograph, good, stride), {}};
    result.shapes.emplace(radius / stride);
    return result;
  };
  scene.coarse = level(fast ? 32.0 : 40.0);
  scene.fine = fast ? scene.coarse : level(60.0);
  const std::vector<Shading> shadings = fit_shadings(scene.coarse.image, good, fast ? 18 : 30);
  for (std::size_t k = 0, next = 0; k < scene.discs.size(); ++k) {
    if (!is_valid(scene.discs[k])) continue;
    scene.shadings[k] = shadings[next++];
    for (std::size_t other = 0; other < scene.discs.size(); ++other) {
      if (other == k || !is_valid(scene.discs[other])) continue;
      const double apart = cv::norm(scene.discs[k].centre_image - scene.discs[other].centre_image);
      if (apart < scene.discs[k].radius_image_px + scene.discs[other].radius_image_px)
        scene.overlapping[k].push_back(other);
    }
  }
  return scene;
}

/// With the others' lines subtracted and the typical line known.
void search_again(const Scene& scene, std::vector<Found>& found) {
  const auto typical = typical_line(found);
  const std::vector<Found> before = found;
  for_each_ball(scene, [&](std::size_t k) {
    if (before[k].accepted || before[k].search.peaks.empty()) return;
    if (typical || has_line_beside(scene, k, before)) search(scene, k, before, typical, found[k]);
  });
}

/// Where so many balls have no line, or one that is tilted as far as was searched, that they may spin about
/// another axis than the line of sight: lines of all tilts.
void search_steep(const Scene& scene, std::vector<Found>& found) {
  constexpr double kSteep_rad = 0.25;
  const auto steep = [&](const Found& one) {
    return !one.accepted || std::abs(one.fit->line.tilt_rad) > kSteep_rad;
  };
  std::size_t searched = 0, without = 0;
  for (const Found& one : found) {
    if (one.search.visible < 0.7) continue;
    ++searched;
    if (steep(one)) ++without;
  }
  if (3 * without <= searched) return;
  const std::vector<Found> before = found;
  for_each_ball(scene, [&](std::size_t k) {
    if (!steep(before[k]) || before[k].search.peaks.empty()) return;
    Found wide;
    wide.range = TiltRange::all;
    search(scene, k, before, {}, wide);
    if (wide.accepted || !before[k].accepted) found[k] = std::move(wide);
  });
  search_again(scene, found);
}

void find_lines(const Scene& scene, std::vector<Found>& found) {
  const std::vector<Found> nothing(found.size());
  for_each_ball(scene, [&](std::size_t k) { search(scene, k, nothing, {}, found[k]); });
  search_again(scene, found);
  search_steep(scene, found);
}

/// Fits all lines again with their common shape, as they are one ball's.
void refine_lines(const Scene& scene, std::vector<Found>& found) {
  const std::vector<Found> before = found;
  std::vector<Near> near(found.size());
  for_each_ball(scene, [&](std::size_t k) {
    if (before[k].accepted) near[k] = near_line(scene, k, before);
  });
  LineProfile profile;
  for (const Near& one : near) profile.add(one.profile);
  const LineShape shape = scene.fine.shapes->best(profile);
  const auto typical = typical_line(before);
  for_each_ball(scene, [&](std::size_t k) {
    if (!before[k].accepted || refine(scene, k, near[k].points, shape, found[k])) return;
    search(scene, k, before, typical, found[k]);
    if (!found[k].accepted) return;
    std::vector<Found> now = before;
    now[k] = found[k];
    near[k] = near_line(scene, k, now);
    if (refine(scene, k, near[k].points, shape, found[k])) return;
    found[k].accepted = false;
    found[k].why =
        check_line(*found[k].fit, true).value_or(Rejection{Reason::no_line, "no line is clear enough"});
  });
  fit_with_common_priors(scene, near, found);
}

}  // namespace

std::vector<Measured<Equator>> measure_equators(const Photograph& photograph, const PlaneMap& map,
                                                std::span<const Outline> outlines, Effort effort) {
  std::vector<Measured<Equator>> results;
  const Scene scene = prepare(photograph, map, outlines, effort);
  std::vector<Found> found(outlines.size());
  if (!scene.coarse.image.intensity.empty()) {
    find_lines(scene, found);
    refine_lines(scene, found);
    reject_few(found);
  }
  const Scatter scatter = common_scatter(found);
  for (std::size_t k = 0; k < found.size(); ++k) results.push_back(result(scene, k, found[k], scatter));
  assert(results.size() == outlines.size());
  return results;
}

}  // namespace strobe::digitize
