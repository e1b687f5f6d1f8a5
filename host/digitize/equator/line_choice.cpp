#include "host/digitize/equator/line_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace strobe::digitize {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180.0;
constexpr double kMuchSaturated = 0.3;  ///< of the ball
constexpr double kMaxContrast = 1.25;   ///< shading and its trade with the neighbours' considered
constexpr double kMinSeen = 0.4;        ///< of a diameter

/// What a line must reach. `score` tells how sure it is that columns across the ball are dark, `contrast_significance`
/// how alike its segments are: seams, print and felt bring about the one or the other. `second`: share of
/// the score that another direction may have.
struct Demand {
  double score = 0.0;
  double contrast_significance = 0.0;
  double both = 0.0;
  double second = 0.0;
};
/// Painted and rendered balls without a line reached scores of 7 and steadinesses of 6, but not together.
constexpr Demand kAlone{4.8, 3.0, 11.0, 0.8};
constexpr Demand kUsual{4.5, 2.5, 9.0, 0.85};

const Demand& demand(bool usual) { return usual ? kUsual : kAlone; }

Rejection weak(double sd) {
  return {Reason::no_line, fmt::format("the darkest line is {:.1f} sd above chance", sd)};
}

Rejection saturated(const LineSearch& search) {
  return {Reason::saturated, fmt::format("{:.0f} % of the ball is saturated", 100.0 * search.saturated)};
}

Rejection unseen(const LineSearch& search) {
  const std::string seen = fmt::format("{:.0f} % of a diameter is seen", 100.0 * search.seen);
  if (search.saturated > kMuchSaturated) return saturated(search);
  if (search.outside > 0.2) return {Reason::at_border, seen};
  return {Reason::no_line, seen};
}

Rejection ambiguous(double one_rad, double other_rad) {
  const auto degrees = [](double rad) {
    return (rad - std::numbers::pi * std::floor(rad / std::numbers::pi)) / kRadPerDegree;
  };
  return {Reason::line_ambiguous, fmt::format("lines at {:.0f} and {:.0f} degrees are as likely",
                                              degrees(one_rad), degrees(other_rad))};
}

/// Seams that happen to pass through the middle bend, by two hundredths of the radius or more, and are lost
/// in places; what is not clear must be the straighter.
constexpr double kMaxWander = 0.016;
constexpr double kClearScore = 9.0;

Rejection bent(const LineFit& fit) {
  return {Reason::no_line,
          fmt::format("the darkest line bends by {:.1f} % of the radius", 100.0 * fit.rms_offset)};
}

Rejection partly(const LineFit& fit) {
  return {Reason::no_line, fmt::format("the darkest line is dark over {:.0f} % of what is seen of it",
                                       100.0 * fit.dark_share)};
}

struct Tried {
  LineFit fit;
  double score = 0.0;
  std::optional<Rejection> find_fault;
};

std::optional<Rejection> fault_of(const LineFit& fit, double score, bool usual) {
  if (auto found = find_fault(fit, usual)) return found;
  if (score < demand(usual).score) return weak(score);
  if (!usual && score < kClearScore) {
    if (fit.rms_offset > 0.75 * kMaxWander) return bent(fit);
    if (fit.dark_share < 0.85) return partly(fit);
  }
  if (score + fit.contrast_significance < demand(usual).both)
    return weak(std::min(score, fit.contrast_significance));
  return std::nullopt;
}

bool same_direction(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, std::numbers::pi)) < 9.0 * kRadPerDegree;
}

/// Another direction that is nearly as likely a line as the one chosen.
const LinePeak* rival(std::span<const LinePeak> peaks, const Tried& chosen) {
  for (const LinePeak& peak : peaks)
    if (peak.score > kAlone.second * chosen.score &&
        !same_direction(peak.line.angle_rad, chosen.fit.line.angle_rad))
      return &peak;
  return nullptr;
}

class Chooser {
 public:
  Chooser(BallPixels& rows, const LineSearch& search, const ShapeGrid& shapes)
      : rows_(rows), shapes_(shapes), peaks_(search.peaks) {
    std::ranges::stable_sort(peaks_, [](const LinePeak& a, const LinePeak& b) { return a.score > b.score; });
  }

  /// The likeliest that stands out.
  LineChoice alone() {
    LineChoice choice;
    choice.why = weak(peaks_.front().score);
    std::optional<Tried> best;
    for (const LinePeak& peak : peaks_) {
      if (peak.score < std::max(4.0, 0.7 * peaks_.front().score)) break;
      auto tried = fit(peak, false);
      if (!tried) continue;
      const bool sound = !tried->find_fault;
      if (sound || !best) best = std::move(tried);
      if (sound) break;
    }
    if (best) take(*best, choice);
    if (!choice.accepted) return choice;
    if (const LinePeak* other = rival(peaks_, *best))
      refuse(ambiguous(best->fit.line.angle_rad, other->line.angle_rad), choice);
    return choice;
  }

  /// The likeliest that is like the usual one.
  LineChoice like(const TypicalLine& usual) {
    LineChoice choice;
    choice.why = weak(peaks_.front().score);
    std::optional<Tried> best;
    for (const LinePeak& peak : peaks_) {
      if (peak.score < kUsual.score) break;
      if (best && peak.score < kUsual.second * best->score) break;
      auto tried = fit(peak, true);
      if (!tried || tried->find_fault || !is_typical(tried->fit.line, usual)) continue;
      if (!best) {
        best = std::move(tried);
      } else if (!same_direction(tried->fit.line.angle_rad, best->fit.line.angle_rad)) {
        take(*best, choice);
        refuse(ambiguous(best->fit.line.angle_rad, tried->fit.line.angle_rad), choice);
        return choice;
      }
    }
    if (best) take(*best, choice);
    return choice;
  }

 private:
  std::optional<Tried> fit(const LinePeak& peak, bool usual) {
    const double radius = rows_.disc().radius_image_px / rows_.stride();
    auto fit =
        fit_line(points_near(rows_, peak.line), radius, peak.line, fit_settings(rows_.disc(), &shapes_));
    if (!fit) return std::nullopt;
    auto found = fault_of(*fit, peak.score, usual);
    return Tried{std::move(*fit), peak.score, std::move(found)};
  }
  static void take(const Tried& tried, LineChoice& choice) {
    choice.fit = tried.fit;
    choice.score = tried.score;
    choice.accepted = !tried.find_fault;
    if (tried.find_fault) choice.why = *tried.find_fault;
  }
  static void refuse(const Rejection& why, LineChoice& choice) {
    choice.accepted = false;
    choice.why = why;
  }

  BallPixels& rows_;
  const ShapeGrid& shapes_;
  std::vector<LinePeak> peaks_;
};

}  // namespace

bool is_typical(const EquatorLine& line, const TypicalLine& usual) {
  const double contrast = line.contrast / usual.contrast, width = line.shape.spread() / usual.spread;
  return contrast > 0.4 && contrast < 2.2 && width > 0.6 && width < 1.7;
}

LineFitSettings fit_settings(const Disc& disc, const ShapeGrid* shapes) {
  LineFitSettings settings;
  settings.offset_sd = std::hypot(0.008, 1.5 * disc.centre_sd);
  settings.shapes = shapes;
  return settings;
}

std::optional<Rejection> find_fault(const LineFit& fit, bool usual) {
  if (fit.dark_share < 0.7) return partly(fit);
  if (fit.rms_offset > kMaxWander) return bent(fit);
  if (fit.line.contrast > kMaxContrast)
    return Rejection{Reason::no_line, fmt::format("the darkest line takes {:.1f} times the light there is",
                                                  fit.line.contrast)};
  if (fit.span < 0.8)
    return Rejection{Reason::no_line,
                     fmt::format("a line is seen over {:.0f} % of a diameter", 50.0 * fit.span)};
  if (fit.contrast_significance < demand(usual).contrast_significance) return weak(fit.contrast_significance);
  if (fit.inlier_share < 0.55)
    return Rejection{Reason::no_line, fmt::format("the darkest line is straight over {:.0f} % of its length",
                                                  100.0 * fit.inlier_share)};
  return std::nullopt;
}

LineChoice choose_line(BallPixels& rows, const LineSearch& search, const ShapeGrid& shapes,
                       const std::optional<TypicalLine>& usual) {
  if (search.peaks.empty() || search.seen < kMinSeen) {
    LineChoice choice;
    choice.why = unseen(search);
    return choice;
  }
  Chooser chooser(rows, search, shapes);
  LineChoice choice = chooser.alone();
  if (!choice.accepted && usual) {
    LineChoice like = chooser.like(*usual);
    if (like.accepted) choice = std::move(like);
  }
  if (!choice.accepted && search.saturated > kMuchSaturated) choice.why = saturated(search);
  return choice;
}

}  // namespace strobe::digitize
