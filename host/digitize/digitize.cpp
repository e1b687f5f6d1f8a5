#include "host/digitize/digitize.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "host/digitize/candidates/candidates.hpp"
#include "host/digitize/equator/equator.hpp"
#include "host/digitize/image_order.hpp"
#include "host/digitize/outliers/ball_size.hpp"
#include "host/digitize/outliers/limb_agreement.hpp"
#include "host/digitize/outliers/spacing.hpp"
#include "host/digitize/outline/outlines.hpp"
#include "host/digitize/surface/contact_image.hpp"
#include "host/digitize/surface/surface_frame.hpp"

namespace strobe::digitize {
namespace {

using reduction::BallImage;
using reduction::Leg;

std::optional<std::string> wrong(const DigitizeSettings& s) {
  const auto positive = [](double v) { return std::isfinite(v) && v > 0.0; };
  if (!(s.ball_diameter_m >= 0.01 && s.ball_diameter_m <= 1.0))
    return "ball_diameter_m: must be within 0.01 and 1";
  if (!positive(s.px_per_m)) return "px_per_m: must be positive";
  if (s.px_per_m_sd && !(std::isfinite(*s.px_per_m_sd) && *s.px_per_m_sd >= 0.0))
    return "px_per_m_sd: must not be negative";
  if (!(s.size_tolerance > 0.0 && s.size_tolerance < 0.9))
    return "size_tolerance: must be above 0 and below 0.9";
  if (s.surface && s.surface->points.size() < 2) return "surface: needs at least two points";
  if (s.flash_times_s) {
    for (std::size_t i = 0; i < s.flash_times_s->size(); ++i) {
      if (!std::isfinite((*s.flash_times_s)[i])) return fmt::format("flash_times_s[{}]: must be finite", i);
      if (i > 0 && !((*s.flash_times_s)[i] > (*s.flash_times_s)[i - 1]))
        return fmt::format("flash_times_s[{}]: must be later than the one before", i);
    }
  }
  return std::nullopt;
}

/// Names the time between its ends.
class Stopwatch {
 public:
  explicit Stopwatch(std::vector<std::pair<std::string, double>>& laps) : laps_(laps) {}
  void lap(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    laps_.emplace_back(stage, std::chrono::duration<double, std::milli>(now - start_).count());
    start_ = now;
  }

 private:
  std::vector<std::pair<std::string, double>>& laps_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// From so many balls on the size is agreed well enough to doubt one.
constexpr std::size_t kAgreeingBalls = 4;
// A centre less well known is that of a sliver at the border, or of arcs that belong to several things.
constexpr double kMaxSdOfDiameter = 0.004;
// Among the balls near the bounce stray arcs are likelier to pass for one that touches.
constexpr double kMaxContactSdOfDiameter = 0.002;
constexpr double kDoubtful_sd = 4.0;
// An outline of borrowed arcs shows its own light on those and, by chance, on a third of the rest; a ball's
// on nearly all. Between the two, and nothing is said where hardly any of it can be told.
constexpr double kMinLimbShare = 0.55;
constexpr double kTellingShare = 0.15;
// Where that light is all there, an outline is a ball's however badly it is known.
constexpr double kSureLimbShare = 0.75;
constexpr double kSureTellingShare = 0.3;

bool is_certain_ball(const LimbAgreement& limb) {
  return limb.told >= kSureTellingShare && limb.share >= kSureLimbShare;
}

bool is_certain_non_ball(const LimbAgreement& limb) {
  return limb.told >= kTellingShare && limb.share < kMinLimbShare;
}

/// Those that are balls beyond doubt; all, where these are few.
std::vector<Outline> certain_balls(const std::vector<Outline>& outlines,
                                   const std::vector<LimbAgreement>& limbs) {
  std::vector<Outline> sure;
  for (std::size_t i = 0; i < outlines.size(); ++i)
    if (is_certain_ball(limbs[i])) sure.push_back(outlines[i]);
  return sure.size() < kAgreeingBalls ? outlines : sure;
}

class Run {
 public:
  Run(const Photograph& photograph, const DigitizeSettings& settings)
      : photograph_(photograph),
        settings_(settings),
        map_(settings.map.is_uncalibrated() ? PlaneMap::plain(photograph.height()) : settings.map),
        expected_(settings.px_per_m * settings.ball_diameter_m) {}

  Digitization run() {
    Stopwatch watch(result_.stage_ms);
    candidates_ = find_candidates(photograph_, search_range(), settings_.effort);
    watch.lap("candidates");
    std::vector<Outline> outlines = keep_sizes(measure(candidates_));
    if (settings_.effort != Effort::fast) outlines = refit_inconsistent(std::move(outlines));
    watch.lap("outlines");
    find_surface(outlines);
    watch.lap("surface");
    choose(keep_lit(std::move(outlines)));
    watch.lap("path");
    fill_frame();
    order_images(result_.frame, result_.outlines, settings_, result_.remarks);
    watch.lap("order");
    put_contacts();
    watch.lap("contacts");
    put_equators();
    watch.lap("equators");
    return std::move(result_);
  }

 private:
  /// On the photograph; the plane's scale may differ from place to place by the lens.
  SearchRange search_range() const {
    double least = 1e300, most = 0.0;
    for (const double u : {0.0, 0.5, 1.0}) {
      for (const double v : {0.0, 0.5, 1.0}) {
        const cv::Matx22d d = map_.derivative({u * photograph_.width(), v * photograph_.height()});
        const double scale = 1.0 / std::sqrt(std::abs(d(0, 0) * d(1, 1) - d(0, 1) * d(1, 0)));
        least = std::min(least, scale);
        most = std::max(most, scale);
      }
    }
    SearchRange range;
    range.radius_min_px = std::max(3.01, 0.5 * expected_ * (1.0 - settings_.size_tolerance) * least);
    range.radius_max_px = std::max(3.02, 0.5 * expected_ * (1.0 + settings_.size_tolerance) * most);
    return range;
  }

  void reject(cv::Point2d centre, double diameter, const char* what, Reason reason, std::string detail) {
    result_.unmeasured.push_back({centre, diameter, what, {reason, std::move(detail)}});
  }

  OutlineSettings outline_settings() const {
    OutlineSettings settings;
    settings.diameter_min_px = expected_ * (1.0 - settings_.size_tolerance);
    settings.diameter_max_px = expected_ * (1.0 + settings_.size_tolerance);
    settings.effort = settings_.effort;
    return settings;
  }

  std::vector<Outline> measure(std::span<const Candidate> candidates) {
    const auto measured = fit_outlines(photograph_, map_, candidates, outline_settings());
    std::vector<Outline> outlines;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      if (measured[i]) {
        outlines.push_back(*measured[i]);
        continue;
      }
      const cv::Point2d centre = map_.to_plane(candidates[i].centre_image);
      reject(centre, expected_, "image", measured[i].error().reason, measured[i].error().detail);
    }
    return outlines;
  }

  std::vector<Outline> keep_sizes(std::vector<Outline> outlines) {
    if (outlines.empty()) return outlines;
    const auto limbs = compare_limbs(photograph_, map_, outlines, settings_.surface);
    const SizeModel size = fit_size_model(certain_balls(outlines, limbs));
    std::vector<Outline> kept;
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      Outline& o = outlines[i];
      const double sd = o.centre_sd();
      if (sd > kMaxSdOfDiameter * o.diameter && !is_certain_ball(limbs[i])) {
        reject(o.centre, o.diameter, "image", Reason::imprecise,
               fmt::format("its centre would be known to {:.1f} px only", sd));
        continue;
      }
      if (!wrong_size(o, size)) {
        kept.push_back(std::move(o));
        continue;
      }
      reject(
          o.centre, o.diameter, "image", Reason::wrong_size,
          fmt::format("{:.1f} px, where the ball's images agree on {:.1f}", o.diameter, size.at(o.centre.x)));
    }
    return kept;
  }

  static Candidate candidate_at(const PlaneMap& map, const Outline& o) {
    const cv::Point2d centre = map.to_image(o.centre);
    const cv::Point2d side = map.to_image(o.centre + cv::Point2d(0.5 * o.diameter, 0.0));
    return {centre, cv::norm(side - centre), o.visible_fraction};
  }

  /// An outline that the others' diameter does not suit has taken some edge for its own that is not: those
  /// are measured again, with the diameter known, and their neighbours with them, whose edges they share.
  std::vector<Outline> refit_inconsistent(std::vector<Outline> outlines) {
    if (outlines.size() < kAgreeingBalls) return outlines;
    const SizeModel size = fit_size_model(outlines);
    const auto doubtful = [&](const Outline& o) {
      const double sd = std::hypot(o.diameter_sd(), size.sd);
      return std::abs(o.diameter - size.at(o.centre.x)) > kDoubtful_sd * sd;
    };
    std::vector<std::size_t> again;
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      const bool concerned = std::any_of(outlines.begin(), outlines.end(), [&](const Outline& o) {
        return doubtful(o) && cv::norm(o.centre - outlines[i].centre) < 1.2 * size.diameter;
      });
      if (!concerned) continue;
      again.push_back(i);
      candidates.push_back(candidate_at(map_, outlines[i]));
    }
    if (again.empty()) return outlines;
    OutlineSettings settings = outline_settings();
    settings.diameter_px = size.at(0.5 * photograph_.width());
    settings.diameter_sd_px = size.sd + std::abs(size.growth) * 0.5 * photograph_.width();
    const auto measured = fit_outlines(photograph_, map_, candidates, settings);
    for (std::size_t k = 0; k < again.size(); ++k) {
      if (measured[k] && doubtful(outlines[again[k]])) outlines[again[k]] = *measured[k];
    }
    return outlines;
  }

  void find_surface(std::span<const Outline> outlines) {
    if (settings_.surface) {
      surface_ = settings_.surface;
      return;
    }
    const auto found = find_surface_line(photograph_, map_, outlines);
    if (found) {
      surface_ = *found;
      if (found->edge_separation_px > 0.0)
        result_.remarks.push_back(
            fmt::format("the plate shows two edges {:.1f} px apart: the surface is taken "
                        "to be half-way, give or take {:.1f} px; calibrate it",
                        found->edge_separation_px, 0.5 * found->sd_px));
    } else {
      result_.no_surface = found.error();
    }
  }

  /// Without those whose light is not a ball's: arcs of several images that together pass for one more.
  std::vector<Outline> keep_lit(std::vector<Outline> outlines) {
    const auto limbs = compare_limbs(photograph_, map_, outlines, surface_);
    std::vector<Outline> kept;
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      Outline& o = outlines[i];
      if (!is_certain_non_ball(limbs[i])) {
        limbs_.push_back(limbs[i]);
        kept.push_back(std::move(o));
        continue;
      }
      reject(o.centre, o.diameter, "image", Reason::few_edges,
             fmt::format("light rises by {:.0f} % only of what it does across the others' outlines",
                         100.0 * limbs[i].share));
    }
    return kept;
  }

  void choose(const std::vector<Outline>& outlines) {
    if (outlines.empty()) return;
    PathContext scene{median_diameter(outlines), surface_.has_value(),
                      surface_ ? surface_frame(*surface_).sd_px : 0.0};
    const auto points = path_points(outlines, surface_);
    const Path path = find_path(points, scene);
    std::vector<char> left(outlines.size(), 0);
    for (const Path::Left& l : path.left) {
      const Outline& o = outlines[static_cast<std::size_t>(l.index)];
      left[static_cast<std::size_t>(l.index)] = 1;
      if (l.below) {
        reject(o.centre, o.diameter, "image", Reason::below_surface, "it lies below the surface");
      } else {
        reject(o.centre, o.diameter, "image", Reason::off_path,
               std::isfinite(l.off_px) ? fmt::format("{:.1f} px off the ball's path", l.off_px)
                                       : std::string("no path leads to it"));
      }
    }
    std::vector<double> quality;
    for (const LimbAgreement& limb : limbs_) quality.push_back(limb.share);
    const std::vector<double> none;
    for (const TooClose& c : find_too_close(path, points, quality, settings_.flash_times_s.value_or(none))) {
      const Outline& o = outlines[static_cast<std::size_t>(c.index)];
      left[static_cast<std::size_t>(c.index)] = 1;
      reject(o.centre, o.diameter, "image", Reason::duplicate,
             fmt::format("{:.1f} px from a better image: nearer than the ball's steps allow", c.apart_px));
    }
    for (const int i : path.contact) {
      const Outline& o = outlines[static_cast<std::size_t>(i)];
      const double sd = points[static_cast<std::size_t>(i)].sd_px;
      if (sd <= std::max(0.5, kMaxContactSdOfDiameter * o.diameter)) continue;
      if (is_certain_ball(limbs_[static_cast<std::size_t>(i)])) continue;
      left[static_cast<std::size_t>(i)] = 1;
      reject(o.centre, o.diameter, "image", Reason::imprecise,
             fmt::format("arcs near the surface that fix a centre to {:.1f} px only", sd));
    }
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      if (!left[i]) result_.outlines.push_back(outlines[i]);
    }
  }

  void fill_frame() {
    reduction::Frame& frame = result_.frame;
    frame.ball_diameter_m = settings_.ball_diameter_m;
    frame.ball_diameter_sd_m = settings_.ball_diameter_sd_m;
    if (settings_.px_per_m_sd) {
      frame.px_per_m = settings_.px_per_m;
      frame.px_per_m_sd = settings_.px_per_m_sd;
    }
    if (surface_) {
      for (const cv::Point2d& p : surface_->points) frame.surface_px.push_back({p.x, p.y});
      if (surface_->sd_px > 0.0) frame.surface_sd_px = surface_->sd_px;
    }
    for (const Outline& o : result_.outlines) {
      BallImage image;
      image.centre_px = {o.centre.x, o.centre.y};
      image.diameter_px = o.diameter;
      const double xy = 0.5 * (o.covariance(0, 1) + o.covariance(1, 0));
      image.centre_cov_px2 = std::array<double, 4>{o.covariance(0, 0), xy, xy, o.covariance(1, 1)};
      image.diameter_sd_px = o.diameter_sd();
      image.source = "auto";
      frame.images.push_back(std::move(image));
    }
  }

  void put_contacts() {
    if (!surface_) return;
    double top_sd = 0.0, width_sd = 0.0;
    for (std::size_t i = 0; i < result_.outlines.size(); ++i) {
      BallImage& image = result_.frame.images[i];
      if (image.leg != Leg::contact) continue;
      const Outline& o = result_.outlines[i];
      const auto contact = measure_contact(o, *surface_);
      if (!contact) {
        reject(o.centre, o.diameter, "top", contact.error().reason, contact.error().detail);
        continue;
      }
      image.top_px = reduction::PointPx{contact->top.x, contact->top.y};
      top_sd = std::max(top_sd, contact->top_sd_px);
      if (!contact->width_px) continue;
      image.contact_width_px = *contact->width_px;
      width_sd = std::max(width_sd, *contact->width_sd_px);
    }
    // A frame has no place for them.
    if (top_sd > 0.0)
      result_.remarks.push_back(
          fmt::format("in contact the ball's top is known to {:.2f} px", top_sd) +
          (width_sd > 0.0 ? fmt::format(", its flat side's width to {:.1f} px", width_sd) : ""));
  }

  void put_equators() {
    const auto equators = measure_equators(photograph_, map_, result_.outlines, settings_.effort);
    for (std::size_t i = 0; i < equators.size(); ++i) {
      if (!equators[i]) {
        const Outline& o = result_.outlines[i];
        reject(o.centre, o.diameter, "equator", equators[i].error().reason, equators[i].error().detail);
        continue;
      }
      result_.frame.images[i].equator_rad = equators[i]->angle_rad;
      result_.frame.images[i].equator_sd_rad = equators[i]->sd_rad;
    }
  }

  const Photograph& photograph_;
  const DigitizeSettings& settings_;
  PlaneMap map_;
  double expected_;
  std::vector<Candidate> candidates_;
  std::optional<SurfaceLine> surface_;
  std::vector<LimbAgreement> limbs_;  ///< of the outlines that a path is looked for through
  Digitization result_;
};

}  // namespace

Result<Digitization> digitize(const Photograph& photograph, const DigitizeSettings& settings) {
  if (const auto problem = wrong(settings)) return fail(*problem);
  if (photograph.light.empty()) return fail(photograph.name + ": no picture");
  try {
    return Run(photograph, settings).run();
  } catch (const cv::Exception& e) {
    return fail(photograph.name + ": " + e.err);
  }
}

}  // namespace strobe::digitize
