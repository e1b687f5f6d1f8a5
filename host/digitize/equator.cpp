#include "host/digitize/equator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "host/digitize/equator_fit.hpp"
#include "host/digitize/equator_search.hpp"

namespace strobe::digitize {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// What is known of one ball's line.
struct Found {
  std::optional<LineFit> fit;
  LineSearch search;
  Rejection why{Reason::no_line, "not looked at"};
  bool accepted = false;
};

struct Scene {
  Effort effort = Effort::standard;
  Blocks blocks;
  std::vector<Disc> discs;
  std::vector<Shading> shadings;
  Flattened flattened;
  std::vector<std::vector<std::size_t>> neighbours;  ///< whose discs overlap
};

/// One ball's part of the photograph.
struct Part {
  Blocks blocks;
  Flattened flattened;
};

Part cut(const Scene& scene, std::size_t k, const std::vector<Found>& found) {
  Part part;
  const cv::Rect box = scene.blocks.around(scene.discs[k], 1.0);
  part.blocks = scene.blocks;
  part.blocks.light = scene.blocks.light(box);
  part.blocks.origin += cv::Point(box.x, box.y) * scene.blocks.stride;
  part.flattened.left = scene.flattened.left(box);
  part.flattened.noise = scene.flattened.noise(box);
  bool own = false;
  for (const std::size_t other : scene.neighbours[k]) {
    if (!found[other].accepted) continue;
    if (!own) part.flattened.left = part.flattened.left.clone();
    own = true;
    add_line(part.blocks, scene.discs[other], scene.shadings[other], found[other].fit->line, -1.0F,
             part.flattened.left);
  }
  return part;
}

FitSettings fit_settings(const Disc& disc, bool shape_known) {
  FitSettings settings;
  settings.offset_sd = std::hypot(0.008, 1.5 * disc.centre_sd);
  settings.shape_known = shape_known;
  return settings;
}

/// How many sd the line's darkness is, every stretch alike.
double evidence(const LineFit& fit) {
  double sum = 0.0;
  for (const Stretch& s : fit.stretches)
    sum += std::clamp(s.dark / (s.dark_sd * std::sqrt(fit.inside_scatter) + 1e-12), -3.0, 3.0);
  return sum / std::sqrt(static_cast<double>(fit.stretches.size()));
}

std::optional<Rejection> fault(const LineFit& fit) {
  if (fit.dark_share < 0.7)
    return Rejection{
        Reason::no_line,
        fmt::format("the darkest line is dark over {:.0f} % of what is seen of it", 100.0 * fit.dark_share)};
  if (fit.span < 0.8)
    return Rejection{Reason::no_line,
                     fmt::format("a line is seen over {:.0f} % of a diameter", 50.0 * fit.span)};
  if (evidence(fit) < 5.0)
    return Rejection{Reason::no_line,
                     fmt::format("the darkest line is {:.1f} sd above chance", evidence(fit))};
  if (fit.standing_share < 0.55)
    return Rejection{Reason::no_line, fmt::format("the darkest line is straight over {:.0f} % of its length",
                                                  100.0 * fit.standing_share)};
  return std::nullopt;
}

Rejection unseen(const LineSearch& search) {
  const std::string seen = fmt::format("{:.0f} % of a diameter is seen", 100.0 * search.seen);
  if (search.saturated > 0.3)
    return {Reason::saturated, fmt::format("{:.0f} % of the ball is saturated", 100.0 * search.saturated)};
  if (search.outside > 0.2) return {Reason::at_border, seen};
  return {Reason::no_line, seen};
}

/// Looks for the line of one ball; others' accepted lines are taken out first.
Found look(const Scene& scene, std::size_t k, const std::vector<Found>& others,
           const std::optional<LineShape>& shape) {
  Found found;
  const Disc& disc = scene.discs[k];
  if (!ok(disc) || scene.blocks.around(disc, 1.0).empty()) {
    found.why = {Reason::at_border, "outside of the photograph"};
    return found;
  }
  const Part part = cut(scene, k, others);
  found.search = search_line(part.blocks, part.flattened, disc, scene.shadings[k], scene.effort);
  const auto& peaks = found.search.peaks;
  if (peaks.empty() || found.search.seen < 0.4) {
    found.why = unseen(found.search);
    return found;
  }
  struct Tried {
    LineFit fit;
    double evidence = 0.0;
    std::optional<Rejection> fault;
  };
  std::vector<Tried> tried;
  for (const LinePeak& peak : peaks) {
    if (peak.score < 0.55 * peaks.front().score || peak.score < 4.0) continue;
    DiscLine start = peak.line;
    if (shape) start.shape = *shape;
    auto fit = fit_line(part.blocks, part.flattened, disc, scene.shadings[k], start,
                        fit_settings(disc, shape.has_value()));
    if (!fit) continue;
    tried.push_back({*fit, evidence(*fit), fault(*fit)});
  }
  if (tried.empty()) {
    found.why = {Reason::no_line,
                 fmt::format("the darkest line is {:.1f} sd above chance", peaks.front().score)};
    return found;
  }
  std::ranges::stable_sort(tried, [](const Tried& a, const Tried& b) {
    if (a.fault.has_value() != b.fault.has_value()) return b.fault.has_value();
    return a.evidence * std::sqrt(a.fit.line.contrast) > b.evidence * std::sqrt(b.fit.line.contrast);
  });
  found.fit = tried.front().fit;
  if (tried.front().fault) {
    found.why = *tried.front().fault;
    return found;
  }
  for (std::size_t t = 1; t < tried.size(); ++t) {
    const double apart =
        std::abs(std::remainder(tried[t].fit.line.angle_rad - found.fit->line.angle_rad, std::numbers::pi));
    if (tried[t].fault || apart < 3.0 * kDegree) continue;
    if (tried[t].evidence > 0.75 * tried.front().evidence &&
        tried[t].fit.line.contrast > 0.5 * found.fit->line.contrast) {
      found.why = {Reason::line_ambiguous,
                   fmt::format("lines at {:.1f} and {:.1f} degrees are as likely",
                               found.fit->line.angle_rad / kDegree, tried[t].fit.line.angle_rad / kDegree)};
      return found;
    }
  }
  found.accepted = true;
  return found;
}

std::vector<Found> look_at_all(const Scene& scene, const std::vector<Found>& before,
                               const std::optional<LineShape>& shape) {
  std::vector<Found> found(scene.discs.size());
  cv::parallel_for_(cv::Range(0, static_cast<int>(found.size())), [&](const cv::Range& range) {
    for (int k = range.start; k < range.end; ++k)
      found[static_cast<std::size_t>(k)] = look(scene, static_cast<std::size_t>(k), before, shape);
  });
  return found;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// The balls of a photograph are one ball with one line.
std::optional<LineShape> common_shape(const std::vector<Found>& found) {
  std::vector<double> half, soft;
  for (const Found& one : found) {
    if (!one.accepted) continue;
    half.push_back(one.fit->line.shape.half_width);
    soft.push_back(one.fit->line.shape.soft);
  }
  if (half.empty()) return std::nullopt;
  return LineShape{median(half), median(soft)};
}

/// Rejects lines that differ in darkness from the others' too much to be the same line.
void reject_odd(std::vector<Found>& found) {
  std::vector<double> contrasts;
  for (const Found& one : found)
    if (one.accepted) contrasts.push_back(one.fit->line.contrast);
  if (contrasts.size() < 3) return;
  const double usual = median(contrasts);
  for (Found& one : found) {
    if (!one.accepted || one.fit->line.contrast > 0.4 * usual) continue;
    one.accepted = false;
    one.why = {Reason::line_ambiguous,
               fmt::format("the line's contrast is {:.2f}, that of most images' {:.2f}",
                           one.fit->line.contrast, usual)};
  }
}

/// Scatter of the stretches, and how much more than alone they matter together, over all balls: few
/// stretches of one tell little of how they scatter.
struct Scatter {
  double mean = 0.0;
  double together = 1.0;
};

Scatter common_scatter(const std::vector<Found>& found) {
  double sum = 0.0, freedom = 0.0, products = 0.0;
  for (const Found& one : found) {
    if (!one.accepted) continue;
    const double per = 1.0 / one.fit->inside_scatter;
    sum += one.fit->freedom * one.fit->scatter * per;
    products += one.fit->freedom * one.fit->neighbours * per;
    freedom += one.fit->freedom;
  }
  Scatter scatter;
  if (freedom <= 0.0 || sum <= 0.0) return scatter;
  scatter.mean = sum / freedom;
  scatter.together = std::clamp(1.0 + 2.0 * products / sum, 1.0, 2.5);
  return scatter;
}

Measured<Equator> result(const Disc& disc, const Found& found, const Scatter& scatter) {
  if (!found.accepted) return tl::unexpected<Rejection>(found.why);
  constexpr double kFreedomOfAll = 12.0;
  const LineFit& fit = *found.fit;
  const double own = fit.scatter, all = scatter.mean * fit.inside_scatter;
  const double variance = (fit.freedom * own + kFreedomOfAll * all) / (fit.freedom + kFreedomOfAll);
  Equator equator;
  equator.sd_rad = std::sqrt(variance * scatter.together * fit.per_variance);
  if (!(equator.sd_rad < 3.0 * kDegree))
    return tl::unexpected<Rejection>(
        Rejection{Reason::imprecise, fmt::format("sd of {:.1f} degrees", equator.sd_rad / kDegree)});
  const cv::Vec2d along =
      disc.plane_from_unit * cv::Vec2d(std::cos(fit.line.angle_rad), std::sin(fit.line.angle_rad));
  equator.angle_rad = std::atan2(along[1], along[0]);
  if (equator.angle_rad < 0.0) equator.angle_rad += std::numbers::pi;
  if (equator.angle_rad >= std::numbers::pi) equator.angle_rad -= std::numbers::pi;
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
    if (!ok(scene.discs.back())) continue;
    good.push_back(scene.discs.back());
    radii.push_back(scene.discs.back().radius_image_px);
  }
  scene.neighbours.resize(scene.discs.size());
  scene.shadings.resize(scene.discs.size());
  if (good.empty()) return scene;
  const double radius_wanted = effort == Effort::fast ? 50.0 : 110.0;
  const int stride = std::max(1, static_cast<int>(median(radii) / radius_wanted));
  scene.blocks = cut_blocks(photograph, good, stride);
  const std::vector<Shading> shadings = fit_shadings(scene.blocks, good);
  scene.flattened = flatten(scene.blocks, good, shadings);
  for (std::size_t k = 0, next = 0; k < scene.discs.size(); ++k) {
    if (!ok(scene.discs[k])) continue;
    scene.shadings[k] = shadings[next++];
    for (std::size_t other = 0; other < scene.discs.size(); ++other) {
      if (other == k || !ok(scene.discs[other])) continue;
      const double apart = cv::norm(scene.discs[k].centre_image - scene.discs[other].centre_image);
      if (apart < scene.discs[k].radius_image_px + scene.discs[other].radius_image_px)
        scene.neighbours[k].push_back(other);
    }
  }
  return scene;
}

}  // namespace

std::vector<Measured<Equator>> measure_equators(const Photograph& photograph, const PlaneMap& map,
                                                std::span<const Outline> outlines, Effort effort) {
  std::vector<Measured<Equator>> results;
  const Scene scene = prepare(photograph, map, outlines, effort);
  std::vector<Found> found(outlines.size());
  if (!scene.blocks.light.empty()) {
    found = look_at_all(scene, found, std::nullopt);
    reject_odd(found);
    // Now with the others' lines out of the way, and the shape that all have.
    found = look_at_all(scene, found, common_shape(found));
    reject_odd(found);
  }
  const Scatter scatter = common_scatter(found);
  for (std::size_t k = 0; k < found.size(); ++k) results.push_back(result(scene.discs[k], found[k], scatter));
  return results;
}

}  // namespace strobe::digitize
