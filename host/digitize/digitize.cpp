#include "host/digitize/digitize.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <set>
#include <span>

#include "host/digitize/candidates/candidates.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/equator/equator.hpp"
#include "host/digitize/outliers/ball_odds.hpp"
#include "host/digitize/outliers/selection.hpp"
#include "host/digitize/outline/outlines.hpp"
#include "host/digitize/path/image_order.hpp"
#include "host/digitize/path/leg_line.hpp"
#include "host/digitize/refit.hpp"
#include "host/digitize/surface/surface_line.hpp"
#include "host/digitize/transfer/transfer_curve.hpp"

namespace strobe::digitize {
namespace {

using reduction::BallImage;
using reduction::Leg;

std::optional<std::string> invalid_setting(const DigitizeSettings& s) {
  const auto positive = [](double v) { return std::isfinite(v) && v > 0.0; };
  if (!(s.ball_diameter_m >= 0.01 && s.ball_diameter_m <= 1.0))
    return "ball_diameter_m: must be from 0.01 to 1";
  if (s.px_per_m && !positive(*s.px_per_m)) return "px_per_m: must be positive";
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

/// Wall time of consecutive stages.
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

constexpr std::size_t kMinOfLostLeg = kMinOwnImages + 1;  // on a line they are a leg

class Digitizer {
 public:
  /// `with_lines`: the balls are large enough to show a drawn line.
  Digitizer(const Photograph& photograph, const PlaneMap& map, const DigitizeSettings& settings,
            bool with_lines)
      : photograph_(photograph), settings_(settings), map_(map), with_lines_(with_lines) {}

  Digitization run() {
    Stopwatch watch(result_.stage_ms);
    const auto candidates = candidates_of_size();
    watch.lap("candidates");
    auto [outlines, size] =
        select_by_size(photograph_, map_, fit(candidates), settings_.surface, result_.unmeasured);
    const std::size_t at_first = outlines.size();
    if (settings_.effort != Effort::fast)
      refit_by_size(photograph_, map_, outline_settings(), size, outlines, result_.unmeasured);
    watch.lap("outlines");
    // What is seen again may lie below it, as a ball's mirror image in a plate does.
    find_surface(std::span(outlines).first(at_first), size);
    watch.lap("surface");
    find_path(outlines);
    tell_surface();
    tell_hidden();
    measure_scale();
    watch.lap("path");
    measure_contacts(result_);
    watch.lap("contacts");
    measure_line_angles();
    watch.lap("equators");
    return std::move(result_);
  }

 private:
  std::vector<Candidate> candidates_of_size() {
    ExpectedSize expected{std::nullopt, settings_.size_tolerance};
    if (settings_.px_per_m) expected.diameter_px = *settings_.px_per_m * settings_.ball_diameter_m;
    SizeDecision decision = decide_size(photograph_, map_, expected, settings_.effort);
    expected_px_ = decision.diameter_px.value_or(0.0);
    size_min_px_ = decision.least_px;
    size_max_px_ = decision.most_px;
    if (!decision.diameter_px)
      result_.remarks.push_back(
          "no ball's outline is whole enough to tell its size: give the scale (--px-per-m, or "
          "camera.px_per_m in "
          "the rig file)");
    if (decision.contradicted_by_px)
      result_.remarks.push_back(fmt::format(
          "the photograph's balls are about {:.0f} px wide, {:.0f} px/m for a ball of {} m, but {:.0f} px "
          "is given ({:.0f} px/m): nothing was measured",
          *decision.contradicted_by_px, *decision.contradicted_by_px / settings_.ball_diameter_m,
          settings_.ball_diameter_m, *expected.diameter_px, *settings_.px_per_m));
    return std::move(decision.candidates);
  }

  OutlineSettings outline_settings() const {
    OutlineSettings settings;
    settings.diameter_min_px = size_min_px_;
    settings.diameter_max_px = size_max_px_;
    settings.effort = settings_.effort;
    settings.ovals = ovals_;
    return settings;
  }

  void reject(const Outline& outline, const char* what, const Rejection& why) {
    result_.unmeasured.push_back({outline.centre, outline.diameter, what, why});
  }

  std::vector<Outline> fit(std::span<const Candidate> candidates) {
    const auto [fitted, ovals] = fit_outlines(photograph_, map_, candidates, outline_settings());
    ovals_ = ovals;
    std::vector<Outline> outlines;
    for (std::size_t i = 0; i < fitted.size(); ++i) {
      if (fitted[i])
        outlines.push_back(*fitted[i]);
      else
        result_.unmeasured.push_back(
            {map_.to_plane(candidates[i].centre_image), expected_px_, "image", fitted[i].error()});
    }
    return outlines;
  }

  /// Not by what is of another size than balls are, as arcs of a mirror image: one below it hides the line.
  void find_surface(std::span<const Outline> outlines, const SizeModel& size) {
    surface_ = settings_.surface;
    if (surface_) return;
    std::vector<Outline> balls;
    // Of a ball that is doubtful by chance the others tell the surface as well.
    std::ranges::copy_if(outlines, std::back_inserter(balls), [&](const Outline& o) {
      const double expected = size.at(o.centre.x);
      return std::abs(o.diameter - expected) <=
             kDoubtful_sd * std::hypot(kSdOfDiameter * expected, size.spread);
    });
    const auto found = find_surface_line(photograph_, map_, balls);
    if (!found) {
      result_.no_surface = found.error();
      return;
    }
    surface_ = *found;
  }

  /// What the operator is to know of a line that was found.
  void tell_surface() {
    if (!surface_ || settings_.surface) return;
    if (surface_->hidden_px > 0.0)
      result_.remarks.push_back(fmt::format(
          "the plate is so light that its near edge, up to {:.1f} px below the far one, may not show: "
          "the surface is known to {:.1f} px; light the plate less, or calibrate it",
          surface_->hidden_px, 0.5 * surface_->sd_px));
    if (surface_->edge_separation_px > 0.0)
      result_.remarks.push_back(
          fmt::format("the plate shows two edges {:.1f} px apart: the surface is taken "
                      "to be half-way, give or take {:.1f} px; calibrate it",
                      surface_->edge_separation_px, 0.5 * surface_->sd_px));
  }

  void fill_frame() {
    reduction::Frame& frame = result_.frame;
    frame.ball_diameter_m = settings_.ball_diameter_m;
    frame.line_drawn = settings_.line_drawn;
    frame.ball_diameter_sd_m = settings_.ball_diameter_sd_m;
    frame.fastest_spin_radps = settings_.fastest_spin_radps;
    if (settings_.px_per_m_sd) {
      frame.px_per_m = settings_.px_per_m;
      frame.px_per_m_sd = settings_.px_per_m_sd;
    }
    if (surface_) {
      for (const cv::Point2d& p : surface_->points) frame.surface_px.push_back({p.x, p.y});
      if (surface_->sd_px > 0.0) frame.surface_sd_px = surface_->sd_px;
    }
    for (const Outline& o : result_.outlines) {
      BallImage& image = frame.images.emplace_back();
      image.centre_px = {o.centre.x, o.centre.y};
      image.diameter_px = o.diameter;
      image.probability = o.probability;
      image.source = "auto";
    }
  }

  void find_path(const std::vector<Outline>& outlines) {
    const Digitization before = result_;
    follow_path(outlines);
    if (passes_surface())
      return follow_path_without_surface(before, outlines,
                                         "the ball flies straight on through the edge that was found");
    if (!surface_ || settings_.surface || off_path(result_) < kMinOfLostLeg) return;
    // An edge that is not the surface's lets no second leg meet the first one there.
    Digitization with = result_;
    const auto surface = surface_;
    follow_path_without_surface(before, outlines, "the ball does not bounce on the edge that was found");
    if (result_.outlines.size() >= with.outlines.size() + kMinOfLostLeg) return;
    result_ = std::move(with);
    surface_ = surface;
  }

  void follow_path(const std::vector<Outline>& outlines) {
    result_.outlines = select_by_path(photograph_, map_, outlines, surface_, settings_, result_.unmeasured);
    fill_frame();
    order_images(result_.frame, result_.outlines, settings_, result_.remarks);
    for (std::size_t i = 0; i < result_.outlines.size(); ++i) {
      add_moved_limb(result_.outlines[i]);
      set_uncertainty(result_.outlines[i], result_.frame.images[i]);
    }
  }

  static void set_uncertainty(const Outline& outline, BallImage& image) {
    const cv::Matx33d& covariance = outline.covariance;
    const double xy = 0.5 * (covariance(0, 1) + covariance(1, 0));
    image.centre_cov_px2 = std::array<double, 4>{covariance(0, 0), xy, xy, covariance(1, 1)};
    image.diameter_sd_px = outline.diameter_sd();
  }

  static std::size_t off_path(const Digitization& digitization) {
    return static_cast<std::size_t>(std::ranges::count_if(
        digitization.unmeasured, [](const Unmeasured& u) { return u.why.reason == Reason::off_path; }));
  }

  void follow_path_without_surface(const Digitization& before, const std::vector<Outline>& outlines,
                                   const char* why) {
    result_ = before;
    surface_.reset();
    result_.no_surface = {Reason::no_plate, why};
    follow_path(outlines);
  }

  /// A line that was found may be the edge of anything, as of a lawn. On a real surface a ball in contact
  /// soon leaves its leg.
  bool passes_surface() const {
    if (!surface_ || settings_.surface) return false;
    std::vector<Eigen::Vector2d> airborne, touching;
    std::set<std::optional<Leg>> legs;
    for (std::size_t i = 0; i < result_.outlines.size(); ++i) {
      const BallImage& image = result_.frame.images[i];
      const bool contact = image.leg == Leg::contact;
      (contact ? touching : airborne).push_back(to_eigen(result_.outlines[i].centre));
      if (!contact) legs.insert(image.leg);
    }
    const auto line = geometry::fit_line(airborne);
    if (touching.empty() || airborne.size() < 3 || legs.size() > 1 || !line) return false;
    return std::ranges::all_of(touching, [&](const Eigen::Vector2d& centre) {
      return std::abs(line->coordinates(centre).y()) <
             0.5 * kFliesOfRadius * result_.outlines.front().diameter;
    });
  }

  /// A ball that falls and rises along one line under flashes that are too close: of places one above the
  /// other hardly any can be measured.
  void tell_hidden() {
    constexpr std::ptrdiff_t kMany = 6;
    if (!surface_ || result_.outlines.empty()) return;
    const geometry::SurfaceFrame axes = surface_frame(*surface_);
    const auto along = [&](const cv::Point2d& centre) { return axes.from_image(to_eigen(centre)).x(); };
    const double at = along(result_.outlines.front().centre);
    const double width = kBandOfDiameter * result_.outlines.front().diameter;
    const auto measured = std::ranges::count_if(
        result_.outlines, [&](const Outline& o) { return std::abs(along(o.centre) - at) <= width; });
    const auto hidden = std::ranges::count_if(result_.unmeasured, [&](const Unmeasured& u) {
      return u.what == std::string_view("image") && std::abs(along(u.centre) - at) <= width;
    });
    if (measured == std::ssize(result_.outlines) && hidden >= kMany && hidden > 2 * measured)
      result_.remarks.push_back(
          "the ball's images lie on each other along one line: of so many hardly one can be measured; leave "
          "steps of one to two diameters from flash to flash (plan: drop_height_m)");
  }

  void measure_scale() {
    if (result_.outlines.empty()) return;
    const SizeModel size = fit_size_model(result_.outlines);
    std::vector<double> diameters, shared;
    for (const Outline& o : result_.outlines) {
      diameters.push_back(o.diameter);
      shared.push_back(o.shared_diameter_sd_px);
    }
    result_.frame.shared_diameter_sd_px = median(std::move(shared));
    BallScale scale;
    scale.images = static_cast<int>(diameters.size());
    scale.diameter_px = median(std::move(diameters));
    scale.diameter_sd_px = std::hypot(size.sd, *result_.frame.shared_diameter_sd_px);
    scale.px_per_m = scale.diameter_px / settings_.ball_diameter_m;
    scale.px_per_m_sd =
        scale.px_per_m * std::hypot(scale.diameter_sd_px / scale.diameter_px,
                                    settings_.ball_diameter_sd_m.value_or(0.0) / settings_.ball_diameter_m);
    result_.scale = scale;
  }

  void measure_line_angles() {
    if (!settings_.line_drawn) {
      if (!result_.outlines.empty())
        result_.remarks.push_back("no line is drawn on the ball: its spin is not measured");
      return;
    }
    if (!with_lines_) {
      for (const Outline& o : result_.outlines)
        reject(o, "equator", {Reason::no_line, "the ball is too small to show one"});
      return;
    }
    const auto equators = measure_equators(photograph_, map_, result_.outlines, settings_.effort);
    for (std::size_t i = 0; i < equators.size(); ++i) {
      if (!equators[i]) {
        reject(result_.outlines[i], "equator", equators[i].error());
        continue;
      }
      set_equator(*equators[i], result_.frame.images[i]);
    }
  }

  static void set_equator(const Equator& equator, BallImage& image) {
    image.equator_rad = equator.angle_rad;
    image.equator_sd_rad = equator.sd_rad;
    if (!equator.tilt) return;
    image.equator_tilt_rad = equator.tilt->tilt_rad;
    image.equator_tilt_sd_rad = equator.tilt->sd_rad;
    image.equator_tilt_correlation = equator.tilt->correlation;
  }

  const Photograph& photograph_;
  const DigitizeSettings& settings_;
  PlaneMap map_;
  bool with_lines_;
  double expected_px_ = 0.0;                      ///< diameter
  double size_min_px_ = 0.0, size_max_px_ = 0.0;  ///< of single balls
  std::optional<OvalModel> ovals_;
  std::optional<SurfaceLine> surface_;
  Digitization result_;
};

/// Where numbers turn out not to be proportional to light, once more with light in their place: a screen's
/// gamma widens every ball by half a pixel.
Digitization digitize_light(const Photograph& photograph, const PlaneMap& map,
                            const DigitizeSettings& settings, bool with_lines) {
  auto digitization = Digitizer(photograph, map, settings, with_lines).run();
  const auto curve = measure_transfer(photograph, map, digitization.outlines);
  digitization.transfer = curve;
  // Files of 8 bits are a screen's as often as a sensor's.
  if (!curve && photograph.bits <= 8 && !digitization.frame.images.empty())
    digitization.remarks.push_back(
        "whether the file's numbers are proportional to light cannot be told, since too few images of the "
        "ball "
        "overlap: a screen's gamma would widen every ball");
  if (!curve || curve->is_proportional()) return digitization;
  digitization = Digitizer(linearized(photograph, *curve), map, settings, with_lines).run();
  digitization.transfer = curve;
  digitization.remarks.push_back(
      fmt::format("the numbers are not proportional to light but to its power {:.2f} ± {:.2f}, as {} places "
                  "tell where images of the ball overlap: this was undone",
                  curve->exponent, curve->sd, curve->crossings));
  return digitization;
}

/// Balls of fewer px are measured on the photograph at twice its size: votes, sectors of an outline and what
/// is sought beside it are several px. Rendered balls are all found from here on, and larger pictures find no
/// more.
constexpr double kSmall_px = 30.0;
/// Larger ones take seconds and gigabytes.
constexpr double kMaxEnlargedPixels = 40e6;

Digitization digitize_small_or_large(const Photograph& photograph, const DigitizeSettings& settings) {
  const PlaneMap map =
      settings.map.is_uncalibrated() ? PlaneMap::uncalibrated(photograph.height()) : settings.map;
  std::optional<Digitization> digitization;
  double diameter_px = settings.px_per_m.value_or(0.0) * settings.ball_diameter_m;
  if (!settings.px_per_m) {
    digitization = digitize_light(photograph, map, settings, true);
    if (!digitization->scale) return std::move(*digitization);
    diameter_px = digitization->scale->diameter_px;
  }
  const cv::Point2d middle(0.5 * photograph.width(), 0.5 * photograph.height());
  const double seen_px = diameter_px * map.image_px_per_plane_px(middle);
  const double pixels = static_cast<double>(photograph.width()) * photograph.height();
  if (seen_px < kSmall_px && 4.0 * pixels <= kMaxEnlargedPixels)
    digitization = digitize_light(enlarged(photograph, 2), map.on_enlarged(2.0), settings, false);
  if (!digitization) digitization = digitize_light(photograph, map, settings, true);
  if (seen_px < kSmall_px && !digitization->outlines.empty())
    digitization->remarks.push_back(
        fmt::format("a ball {:.0f} px wide is small: of images that overlap some may be missed, from {:.0f} "
                    "px on hardly any",
                    seen_px, kSmall_px));
  return std::move(*digitization);
}

}  // namespace

Result<Digitization> digitize(const Photograph& photograph, const DigitizeSettings& settings) {
  if (const auto problem = invalid_setting(settings)) return fail(*problem);
  if (photograph.intensity.empty()) return fail(photograph.name + ": it has no pixels");
  try {
    auto digitization = digitize_small_or_large(photograph, settings);
    if (photograph.orientation != 1)
      digitization.remarks.push_back(fmt::format(
          "the camera says that it was held otherwise than upright (EXIF orientation {}): the pixels "
          "are taken as they are stored, with the first row at the top",
          photograph.orientation));
    return digitization;
  } catch (const cv::Exception& e) {
    return fail(photograph.name + ": " + e.err);
  }
}

void measure_contacts(Digitization& digitization) {
  const auto surface = surface_line_of(digitization.frame);
  if (!surface) return;
  double top_sd = 0.0, width_sd = 0.0;
  for (std::size_t i = 0; i < digitization.outlines.size(); ++i) {
    BallImage& image = digitization.frame.images[i];
    if (image.leg != Leg::contact || image.top_px) continue;
    const Outline& o = digitization.outlines[i];
    const auto contact = measure_contact(o, *surface);
    if (!contact) {
      digitization.unmeasured.push_back({o.centre, o.diameter, "top", contact.error()});
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
    digitization.remarks.push_back(
        fmt::format("in contact the ball's top is known to {:.2f} px", top_sd) +
        (width_sd > 0.0 ? fmt::format(", its flat side's width to {:.1f} px", width_sd) : ""));
}

}  // namespace strobe::digitize
