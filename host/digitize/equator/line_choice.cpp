#include "host/digitize/equator/line_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace strobe::digitize {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180.0;
constexpr double kMaxSaturated = 0.3;  ///< of the ball
constexpr double kMaxContrast = 1.25;  ///< shading and its trade with the neighbours' considered
constexpr double kMinVisible = 0.4;    ///< of a diameter

/// Thresholds of a line. `score`: z-score of the search; `contrast_significance`: of its segments. Seams,
/// print and felt reach the one or the other. `second`: fraction of the score that a rival direction may
/// have.
struct Thresholds {
  double score = 0.0;
  double contrast_significance = 0.0;
  double both = 0.0;
  double second = 0.0;
};
/// Painted and rendered balls without a line reached scores of 7 and steadinesses of 6, but not together.
constexpr Thresholds kAlone{4.8, 3.0, 11.0, 0.8};
constexpr Thresholds kTypical{4.5, 2.5, 9.0, 0.85};
/// Among lines of all tilts some follow a seam: of painted balls without a line the steadiness reached 13; of
/// balls with one it was 24 or more.
constexpr double kSteadyAtAnyTilt = 21.0;

const Thresholds& thresholds(bool typical) { return typical ? kTypical : kAlone; }

Rejection insignificant(double sd) {
  return {Reason::no_line, fmt::format("the darkest line is {:.1f} sd above chance", sd)};
}

Rejection saturated(const LineSearch& search) {
  return {Reason::saturated, fmt::format("{:.0f} % of the ball is saturated", 100.0 * search.saturated)};
}

Rejection invisible(const LineSearch& search) {
  const std::string seen = fmt::format("{:.0f} % of a diameter is seen", 100.0 * search.visible);
  if (search.saturated > kMaxSaturated) return saturated(search);
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

/// Seams that pass through the middle are curved, by two hundredths of the radius or more, and interrupted.
/// Unclear lines must be straighter than that.
constexpr double kMaxRmsOffset = 0.016;
constexpr double kClearScore = 9.0;

Rejection bent(const LineFit& fit) {
  return {Reason::no_line,
          fmt::format("the darkest line bends by {:.1f} % of the radius", 100.0 * fit.rms_offset)};
}

Rejection partly(const LineFit& fit) {
  return {Reason::no_line, fmt::format("the darkest line is dark over {:.0f} % of what is seen of it",
                                       100.0 * fit.dark_fraction)};
}

struct Attempt {
  LineFit fit;
  double score = 0.0;
  std::optional<Rejection> rejection;
};

std::optional<Rejection> check_peak(const LineFit& fit, double score, TiltRange range, bool typical) {
  if (auto found = check_line(fit, typical)) return found;
  if (score < thresholds(typical).score) return insignificant(score);
  if (!typical && range == TiltRange::all && fit.contrast_significance < kSteadyAtAnyTilt)
    return insignificant(fit.contrast_significance);
  if (!typical && score < kClearScore) {
    if (fit.rms_offset > 0.75 * kMaxRmsOffset) return bent(fit);
    if (fit.dark_fraction < 0.85) return partly(fit);
  }
  if (score + fit.contrast_significance < thresholds(typical).both)
    return insignificant(std::min(score, fit.contrast_significance));
  return std::nullopt;
}

bool same_direction(const EquatorLine& a, const EquatorLine& b) {
  return angle_between(a, b) < 9.0 * kRadPerDegree;
}

/// Another direction that is nearly as likely as the chosen line. Returns null if there is none.
const LinePeak* rival(std::span<const LinePeak> peaks, const Attempt& chosen, TiltRange range) {
  // Of all tilts there is one that lies in what a clear line leaves of the shading, faint and long.
  const double faintest = range == TiltRange::all ? 0.4 * chosen.fit.line.contrast : 0.0;
  for (const LinePeak& peak : peaks)
    if (peak.score > kAlone.second * chosen.score && peak.line.contrast > faintest &&
        !same_direction(peak.line, chosen.fit.line))
      return &peak;
  return nullptr;
}

class Chooser {
 public:
  Chooser(BallPixels& pixels, const LineSearch& search, const ShapeGrid& shapes, TiltRange range)
      : pixels_(pixels), shapes_(shapes), range_(range), peaks_(search.peaks) {
    std::ranges::stable_sort(peaks_, [](const LinePeak& a, const LinePeak& b) { return a.score > b.score; });
  }

  /// The most likely line that stands out.
  LineChoice alone() {
    LineChoice choice;
    choice.why = insignificant(peaks_.front().score);
    std::optional<Attempt> best;
    for (const LinePeak& peak : peaks_) {
      if (peak.score < std::max(4.0, 0.7 * peaks_.front().score)) break;
      auto attempt = fit(peak, false);
      if (!attempt) continue;
      const bool passes = !attempt->rejection;
      if (passes || !best) best = std::move(attempt);
      if (passes) break;
    }
    if (best) set(*best, choice);
    if (!choice.accepted) return choice;
    if (const LinePeak* other = rival(peaks_, *best, range_))
      reject(ambiguous(best->fit.line.angle_rad, other->line.angle_rad), choice);
    return choice;
  }

  /// The most likely line that looks like the typical one.
  LineChoice like(const TypicalLine& typical) {
    LineChoice choice;
    choice.why = insignificant(peaks_.front().score);
    std::optional<Attempt> best;
    for (const LinePeak& peak : peaks_) {
      if (peak.score < kTypical.score) break;
      if (best && peak.score < kTypical.second * best->score) break;
      auto attempt = fit(peak, true);
      if (!attempt || attempt->rejection || !is_typical(attempt->fit.line, typical)) continue;
      if (!best) {
        best = std::move(attempt);
      } else if (!same_direction(attempt->fit.line, best->fit.line)) {
        set(*best, choice);
        reject(ambiguous(best->fit.line.angle_rad, attempt->fit.line.angle_rad), choice);
        return choice;
      }
    }
    if (best) set(*best, choice);
    return choice;
  }

 private:
  std::optional<Attempt> fit(const LinePeak& peak, bool typical) {
    const double radius = pixels_.disc().radius_image_px / pixels_.stride();
    auto fit = fit_line(points_near(pixels_, peak.line), radius, peak.line,
                        line_fit_settings(pixels_.disc(), range_, peak.line.tilt_rad, &shapes_));
    if (!fit) return std::nullopt;
    auto found = check_peak(*fit, peak.score, range_, typical);
    return Attempt{std::move(*fit), peak.score, std::move(found)};
  }
  static void set(const Attempt& attempt, LineChoice& choice) {
    choice.fit = attempt.fit;
    choice.score = attempt.score;
    choice.accepted = !attempt.rejection;
    if (attempt.rejection) choice.why = *attempt.rejection;
  }
  static void reject(const Rejection& why, LineChoice& choice) {
    choice.accepted = false;
    choice.why = why;
  }

  BallPixels& pixels_;
  const ShapeGrid& shapes_;
  TiltRange range_;
  std::vector<LinePeak> peaks_;
};

}  // namespace

bool is_typical(const EquatorLine& line, const TypicalLine& typical) {
  const double contrast = line.contrast / typical.contrast, width = line.shape.spread() / typical.spread;
  return contrast > 0.4 && contrast < 2.2 && width > 0.6 && width < 1.7;
}

LineFitSettings line_fit_settings(const Disc& disc, TiltRange range, double tilt_rad,
                                  const ShapeGrid* shapes) {
  LineFitSettings settings;
  settings.offset_sd = std::hypot(0.008, 1.5 * disc.centre_sd);
  if (range == TiltRange::all) {
    settings.tilt_sd = std::max(settings.tilt_sd, 1.5 * std::abs(tilt_rad));
    settings.most_tilt_rad = kMaxTilt_rad;
  }
  settings.centre_sd = disc.centre_sd;
  settings.radius_sd = disc.radius_sd;
  settings.blur = disc.blur;
  settings.shapes = shapes;
  return settings;
}

std::optional<Rejection> check_line(const LineFit& fit, bool typical) {
  if (fit.dark_fraction < 0.7) return partly(fit);
  if (fit.rms_offset > kMaxRmsOffset) return bent(fit);
  if (fit.line.contrast > kMaxContrast)
    return Rejection{Reason::no_line, fmt::format("the darkest line takes {:.1f} times the light there is",
                                                  fit.line.contrast)};
  if (fit.span < 0.8)
    return Rejection{Reason::no_line,
                     fmt::format("a line is seen over {:.0f} % of a diameter", 50.0 * fit.span)};
  if (fit.contrast_significance < thresholds(typical).contrast_significance)
    return insignificant(fit.contrast_significance);
  if (fit.inlier_fraction < 0.55)
    return Rejection{Reason::no_line, fmt::format("the darkest line is straight over {:.0f} % of its length",
                                                  100.0 * fit.inlier_fraction)};
  return std::nullopt;
}

LineChoice choose_line(BallPixels& pixels, const LineSearch& search, const ShapeGrid& shapes, TiltRange range,
                       const std::optional<TypicalLine>& typical) {
  if (search.peaks.empty() || search.visible < kMinVisible) {
    LineChoice choice;
    choice.why = invisible(search);
    return choice;
  }
  Chooser chooser(pixels, search, shapes, range);
  LineChoice choice = chooser.alone();
  if (!choice.accepted && typical) {
    LineChoice like = chooser.like(*typical);
    if (like.accepted) choice = std::move(like);
  }
  if (!choice.accepted && search.saturated > kMaxSaturated) choice.why = saturated(search);
  return choice;
}

}  // namespace strobe::digitize
