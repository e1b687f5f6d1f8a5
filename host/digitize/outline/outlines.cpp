#include "host/digitize/outline/outlines.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <opencv2/core/utility.hpp>

#include "host/digitize/core/statistics.hpp"
#include "host/digitize/outline/circle_ransac.hpp"
#include "host/digitize/outline/outline_fit.hpp"

namespace strobe::digitize {

namespace {

struct Sectors {
  double sectors_px, outside_px, inside_px;
};
// Lengths around the default, none a multiple of another, and depths from what the blur needs to twice that.
constexpr std::array<Sectors, 5> kVariants{
    {{8.0, 5.0, 8.0}, {5.0, 3.0, 4.0}, {6.5, 4.0, 6.0}, {10.0, 4.0, 6.0}, {12.0, 5.0, 5.0}}};

OutlineVector parameters(const OutlineShape& shape) {
  return {shape.centre.x, shape.centre.y, shape.radius, shape.oval_cos, shape.oval_sin};
}

/// Interquartile mean.
double interquartile_mean(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t off = values.size() / 4;
  double sum = 0.0;
  for (std::size_t i = off; i < values.size() - off; ++i) sum += values[i];
  return sum / static_cast<double>(values.size() - 2 * off);
}

template <typename Value>
double mean_of(const std::vector<FittedOutline>& all, const Value& value) {
  std::vector<double> values;
  for (const FittedOutline& one : all) values.push_back(value(one));
  return interquartile_mean(std::move(values));
}

/// Mean of the fits' own covariances, and their scatter about the mean.
OutlineMatrix covariance_of(const std::vector<FittedOutline>& all, const OutlineShape& shape) {
  OutlineMatrix sum = OutlineMatrix::zeros();
  for (const FittedOutline& one : all) {
    const OutlineVector off = parameters(one.shape) - parameters(shape);
    sum += one.covariance + off * off.t();
  }
  return sum * (1.0 / static_cast<double>(all.size()));
}

}  // namespace

std::optional<FittedOutline> fit_outline_bagged(const Photograph& photograph, const LocalFrame& frame,
                                                const OutlineShape& start, double sigma_px,
                                                std::span<const OutlineShape> neighbours,
                                                const OutlineFitSettings& settings) {
  std::vector<FittedOutline> all;
  for (const Sectors& variant : kVariants) {
    OutlineFitSettings own = settings;
    own.sectors_px = variant.sectors_px;
    own.outside_px = variant.outside_px;
    own.inside_px = variant.inside_px;
    if (auto fitted = fit_outline(photograph, frame, start, sigma_px, neighbours, own))
      all.push_back(std::move(*fitted));
  }
  if (all.empty()) return std::nullopt;
  FittedOutline result = all.front();
  const auto of = [&](int a) {
    return mean_of(all, [a](const FittedOutline& one) { return parameters(one.shape)[a]; });
  };
  result.shape.centre = {of(0), of(1)};
  result.shape.radius = of(2);
  result.shape.oval_cos = of(3);
  result.shape.oval_sin = of(4);
  result.sigma_px = mean_of(all, [](const FittedOutline& one) { return one.sigma_px; });
  result.rms_px = mean_of(all, [](const FittedOutline& one) { return one.rms_px; });
  result.shared_radius_sd_px = mean_of(all, [](const FittedOutline& one) { return one.shared_radius_sd_px; });
  result.covariance = covariance_of(all, result.shape);
  return result;
}

namespace {

constexpr double kLargeBlur = 1.3;
// A centre less certain than this share of the diameter tells no speed: images are about a diameter apart, a
// leg has three or more, and a percent or two is wanted. Whether it is a ball's is another question
// (outliers/selection.hpp).
constexpr double kMaxSdOfDiameter = 0.03;

/// A circle in plane px.
struct PlaneDisc {
  cv::Point2d centre;
  double radius = 0.0;
  double oval_cos = 0.0, oval_sin = 0.0;
  double rise = 0.0;
};

/// The state of one candidate.
struct Work {
  std::optional<LocalFrame> frame;
  std::optional<CoarseCircle> coarse;
  std::optional<FittedOutline> fitted;
  std::optional<PlaneDisc> disc;     ///< the current estimate; absent: no outline
  std::optional<OvalSample> sample;  ///< its part of the oval model
  std::optional<Rejection> rejection;
};

/// The shape of a ball at that place, in a frame.
OutlineShape shape_of(const PlaneMap& map, const LocalFrame& frame, const PlaneDisc& disc) {
  const EllipsePx ellipse = map.outline(disc.centre, 2.0 * disc.radius);
  OutlineShape shape;
  shape.centre = frame.from_plane(ellipse.centre);
  shape.radius = std::sqrt(ellipse.along * ellipse.across) * frame.scale();
  shape.oval_cos = disc.oval_cos * frame.scale();
  shape.oval_sin = disc.oval_sin * frame.scale();
  shape.along = std::sqrt(ellipse.along / ellipse.across);
  shape.across = 1.0 / shape.along;
  shape.axis = {std::cos(ellipse.axis_rad), std::sin(ellipse.axis_rad)};
  shape.rise = disc.rise;
  return shape;
}

/// The ball with that outline: perspective shifts and enlarges it by an amount that hardly depends on the
/// ball.
PlaneDisc disc_of(const PlaneMap& map, const LocalFrame& frame, const OutlineShape& shape) {
  PlaneDisc disc{frame.to_plane(shape.centre), shape.radius / frame.scale(), shape.oval_cos / frame.scale(),
                 shape.oval_sin / frame.scale(), shape.rise};
  for (int i = 0; i < 3; ++i) {
    const EllipsePx ellipse = map.outline(disc.centre, 2.0 * disc.radius);
    disc.centre += frame.to_plane(shape.centre) - ellipse.centre;
    disc.radius *= shape.radius / frame.scale() / std::sqrt(ellipse.along * ellipse.across);
  }
  return disc;
}

class OutlineFitter {
 public:
  OutlineFitter(const Photograph& photograph, const PlaneMap& map, std::span<const Candidate> candidates,
                const OutlineSettings& settings)
      : photograph_(photograph),
        map_(map),
        candidates_(candidates),
        settings_(settings),
        works_(candidates.size()),
        oval_model_(settings.ovals) {}

  FittedOutlines run() {
    each([this](std::size_t i) { search(i); });
    const int sweeps = settings_.effort == Effort::fast ? 1 : 2;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      const std::vector<Work> before = works_;
      each([this, &before, sweep](std::size_t i) { fit(i, before, sweep); });
      for (std::size_t i = 0; i < works_.size(); ++i) check(i);
      drop_duplicates();
      if (sweep == 0 && !settings_.ovals) share_ovality();
    }
    FittedOutlines results;
    for (std::size_t i = 0; i < works_.size(); ++i) results.outlines.push_back(result(i));
    results.ovals = oval_model_;
    assert(results.outlines.size() == candidates_.size());
    return results;
  }

 private:
  template <typename Do>
  void each(const Do& one) {
    cv::parallel_for_(cv::Range(0, static_cast<int>(works_.size())), [&](const cv::Range& range) {
      for (int i = range.start; i < range.end; ++i) one(static_cast<std::size_t>(i));
    });
  }

  double expected_diameter(cv::Point2d centre) const {
    return *settings_.diameter_px + settings_.diameter_slope * centre.x;
  }

  static void reject(Work& work, Reason reason, std::string detail) {
    work.disc.reset();
    work.rejection = Rejection{reason, std::move(detail)};
  }

  void search(std::size_t i) {
    Work& work = works_[i];
    const Candidate& candidate = candidates_[i];
    work.frame.emplace(map_, candidate.centre_image, 1.3 * candidate.radius_image_px + 10.0);
    CoarseSearch search;
    search.radius_px = candidate.radius_image_px;
    double least = settings_.diameter_min_px, most = settings_.diameter_max_px;
    if (settings_.diameter_px && settings_.diameter_sd_px) {
      const double expected = expected_diameter(map_.to_plane(candidate.centre_image));
      least = std::max(least, expected - kDoubtful_sd * *settings_.diameter_sd_px);
      most = std::min(most, expected + kDoubtful_sd * *settings_.diameter_sd_px);
    }
    search.radius_min_px = 0.48 * least * work.frame->scale();
    search.radius_max_px = 0.52 * most * work.frame->scale();
    search.reach_px = std::max(5.0, 0.09 * candidate.radius_image_px);
    work.coarse = find_circle_ransac(photograph_, *work.frame, search);
    if (!work.coarse || work.coarse->support < 0.06) {
      reject(work, Reason::few_edges, "hardly an edge where the outline should be");
      return;
    }
    work.disc =
        PlaneDisc{work.frame->to_plane(work.coarse->centre), work.coarse->radius / work.frame->scale()};
  }

  std::vector<OutlineShape> neighbours(std::size_t i, const std::vector<Work>& all) const {
    std::vector<OutlineShape> shapes;
    for (std::size_t j = 0; j < all.size(); ++j) {
      if (j == i || !all[j].disc) continue;
      const double apart = cv::norm(all[j].disc->centre - all[i].disc->centre);
      if (apart < 1.2 * (all[i].disc->radius + all[j].disc->radius))
        shapes.push_back(shape_of(map_, *works_[i].frame, *all[j].disc));
    }
    for (const Outline& o : settings_.neighbours) {
      const PlaneDisc disc{.centre = o.centre, .radius = 0.5 * o.diameter, .rise = o.rise};
      if (cv::norm(disc.centre - all[i].disc->centre) < 1.2 * (all[i].disc->radius + disc.radius))
        shapes.push_back(shape_of(map_, *works_[i].frame, disc));
    }
    return shapes;
  }

  /// So badly seen that measuring it a second time, more finely, would not make a ball of it: what is seen on
  /// less than a third of its outline on the photograph is none, unless its centre is well fixed all the
  /// same.
  static bool is_hopeless(const Work& work) {
    const auto& covariance = work.fitted->covariance;
    const double sd = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
    return work.fitted->visible_fraction < (1.0 - work.fitted->outside_fraction) / 3.0 &&
           sd > 0.01 * work.fitted->shape.radius;
  }

  void fit(std::size_t i, const std::vector<Work>& before, int sweep) {
    Work& work = works_[i];
    if (!before[i].disc || (sweep > 0 && is_hopeless(before[i]))) return;
    OutlineFitSettings settings;
    settings.steps = settings_.effort == Effort::fast ? 4 : sweep == 0 ? 3 : 2;
    settings.coarse_steps = sweep == 0 ? 2 : 0;
    settings.further_steps = settings_.effort == Effort::fast || sweep > 0 ? 16 : 0;
    settings.sectors_px = settings_.effort == Effort::fast ? 12.0 : 8.0;
    settings.rays_px = settings_.effort == Effort::fast || sweep == 0 ? 2.0 : 1.0;
    settings.oval_covariance = oval_covariance(before[i].disc->centre);
    if (const auto ovals = others_ovals(before[i])) {
      settings.oval = ovals->at(before[i].disc->centre);
      settings.oval_covariance = ovals->covariance(before[i].disc->centre);
    }
    if (settings_.diameter_px && settings_.diameter_sd_px) {
      settings.radius_px = 0.5 * expected_diameter(before[i].disc->centre) * work.frame->scale();
      settings.radius_sd_px = 0.5 * *settings_.diameter_sd_px * work.frame->scale();
    }
    const double sigma = sweep == 0 ? 1.5 : before[i].fitted->sigma_px;
    const OutlineShape start = shape_of(map_, *work.frame, *before[i].disc);
    const std::vector<OutlineShape> others = neighbours(i, before);
    const auto fit_once =
        settings_.effort == Effort::thorough && sweep > 0 ? fit_outline_bagged : fit_outline;
    work.fitted = fit_once(photograph_, *work.frame, start, sigma, others, settings);
    if (work.fitted && settings_.effort == Effort::fast && work.fitted->sigma_px > kLargeBlur * sigma) {
      // The profile was too short for this blur.
      settings.steps = 2, settings.coarse_steps = 0;
      work.fitted =
          fit_outline(photograph_, *work.frame, work.fitted->shape, work.fitted->sigma_px, others, settings);
    }
    if (!work.fitted) {
      reject(work, Reason::few_edges, "no stretch of an outline is clear enough to measure");
      return;
    }
    work.disc = disc_of(map_, *work.frame, work.fitted->shape);
  }

  cv::Point2d middle() const {
    return map_.to_plane({0.5 * photograph_.width(), 0.5 * photograph_.height()});
  }
  double reach_px() const { return cv::norm(map_.to_plane({0.0, 0.0}) - middle()); }

  /// Prior sd of an outline's ovality over its radius, in every direction.
  double oval_sd() const { return map_.viewpoint() ? 0.002 : 0.005; }

  /// Prior sd in a corner, away from the middle. A normal lens, whose focal length is the photograph's
  /// diagonal, makes it a quarter of the square of half the diagonal over that.
  double corner_sd() const { return map_.viewpoint() ? oval_sd() : 1.0 / 16.0; }
  double stretch_sd(cv::Point2d centre) const {
    return corner_sd() * std::pow(cv::norm(centre - middle()) / reach_px(), 2);
  }

  cv::Matx22d oval_covariance(cv::Point2d centre) const {
    const cv::Point2d d = centre - middle();
    const double twice = 2.0 * std::atan2(d.y, d.x);
    const cv::Vec2d away = stretch_sd(centre) * cv::Vec2d(std::cos(twice), std::sin(twice));
    return cv::Matx22d::eye() * std::pow(oval_sd(), 2) + away * away.t();
  }

  /// What the outline alone tells of its ovality, without the prior. Returns nullopt if that is nothing, or
  /// if arcs of less than half a circle, which anything may make, are all that is seen.
  std::optional<OvalSample> oval_of(const Work& work) const {
    if (work.fitted->visible_fraction < 0.5) return std::nullopt;
    const OutlineShape& shape = work.fitted->shape;
    const double unit = 1.0 / shape.radius;
    const cv::Matx22d both = (work.fitted->covariance.get_minor<2, 2>(3, 3) * (unit * unit)).inv();
    const cv::Matx22d information = both - oval_covariance(work.disc->centre).inv();
    if (!(information(0, 0) > 0.0 && cv::determinant(information) > 0.0)) return std::nullopt;
    const cv::Matx22d own = information.inv();
    return OvalSample{work.disc->centre, own * both * cv::Vec2d(shape.oval_cos, shape.oval_sin) * unit, own};
  }

  /// The oval model without this outline's own sample. One that is fitted again with the model of a fit
  /// before keeps its part of it.
  std::optional<OvalModel> others_ovals(const Work& work) const {
    return oval_model_ && work.sample ? oval_model_->without(*work.sample) : oval_model_;
  }

  void share_ovality() {
    std::vector<OvalSample> samples;
    for (Work& work : works_) {
      if (!work.disc) continue;
      work.sample = oval_of(work);
      if (work.sample) samples.push_back(*work.sample);
    }
    oval_model_ = fit_oval_model(samples, middle(), reach_px(), corner_sd());
    if (oval_model_ && std::hypot(oval_model_->scatter(), kSquare_sd) >= oval_sd()) oval_model_.reset();
    if (!oval_model_) return;
    for (Work& work : works_) {
      if (!work.disc) continue;
      const cv::Point2d at = work.disc->centre;
      const OvalModel ovals = *others_ovals(work);
      apply_oval_prior(*work.fitted, ovals.at(at), ovals.covariance(at), oval_covariance(at));
      work.disc = disc_of(map_, *work.frame, work.fitted->shape);
    }
  }

  /// More than a ball is, seen through that lens, or through any where that is not known yet.
  bool is_oval(const Work& work) const {
    constexpr double kMaxOval = 0.03;
    const OutlineShape& shape = work.fitted->shape;
    const cv::Vec2d oval = cv::Vec2d(shape.oval_cos, shape.oval_sin) * (1.0 / shape.radius);
    const cv::Point2d at = work.disc->centre;
    if (oval_model_) return cv::norm(oval - oval_model_->at(at)) > kMaxOval;
    return cv::norm(oval) > kMaxOval + 2.0 * stretch_sd(at);
  }

  void check(std::size_t i) {
    Work& work = works_[i];
    if (!work.disc) return;
    const FittedOutline& fitted = *work.fitted;
    const double diameter = 2.0 * work.disc->radius;
    const double degrees = 360.0 * fitted.visible_fraction;
    const double sd =
        std::sqrt(std::max(fitted.covariance(0, 0), fitted.covariance(1, 1))) / work.frame->scale();
    if (fitted.visible_fraction < 0.1) {
      const Reason reason = fitted.outside_fraction > 0.4     ? Reason::at_border
                            : fitted.saturated_fraction > 0.4 ? Reason::saturated
                                                              : Reason::few_edges;
      reject(work, reason, fmt::format("outline seen over {:.0f} of 360 degrees", degrees));
    } else if (diameter < settings_.diameter_min_px || diameter > settings_.diameter_max_px) {
      reject(work, Reason::wrong_size,
             fmt::format("diameter {:.1f} px is not between {:.1f} and {:.1f}", diameter,
                         settings_.diameter_min_px, settings_.diameter_max_px));
    } else if (fitted.rms_px > std::max({1.0, 0.01 * fitted.shape.radius, fitted.sigma_px}) ||
               is_oval(work)) {
      // Offsets are sought within two sd of the blur; those of no outline at all lie anywhere there, with an
      // rms of 2/sqrt(3) = 1.15 sd, give or take .1 over 24 sectors.
      reject(work, Reason::not_round,
             fmt::format("edges are {:.2f} px rms from an ellipse that a ball can have", fitted.rms_px));
    } else if (sd > kMaxSdOfDiameter * diameter) {
      reject(work, Reason::imprecise, fmt::format("centre known to {:.1f} px only", sd));
    }
  }

  double quality(std::size_t i) const { return works_[i].fitted->visible_fraction; }

  void drop_duplicates() {
    constexpr double kSameOfRadii = 0.02;
    for (std::size_t i = 0; i < works_.size(); ++i) {
      for (const Outline& o : settings_.neighbours) {
        if (!works_[i].disc) break;
        const double apart = cv::norm(works_[i].disc->centre - o.centre);
        if (apart <= kSameOfRadii * (works_[i].disc->radius + 0.5 * o.diameter))
          reject(works_[i], Reason::duplicate, fmt::format("{:.1f} px from an outline", apart));
      }
      for (std::size_t j = 0; j < works_.size(); ++j) {
        if (i == j || !works_[i].disc || !works_[j].disc) continue;
        const double apart = cv::norm(works_[i].disc->centre - works_[j].disc->centre);
        if (apart > kSameOfRadii * (works_[i].disc->radius + works_[j].disc->radius)) continue;
        if (quality(j) > quality(i) || (quality(j) == quality(i) && j < i))
          reject(works_[i], Reason::duplicate,
                 fmt::format("{:.1f} px from an outline that fits better", apart));
      }
    }
  }

  Measured<Outline> result(std::size_t i) const {
    const Work& work = works_[i];
    if (!work.disc)
      return tl::unexpected<Rejection>(work.rejection.value_or(Rejection{Reason::few_edges, "no outline"}));
    const FittedOutline& fitted = *work.fitted;
    const double scale = work.frame->scale();
    Outline outline;
    outline.centre = work.disc->centre;
    outline.diameter = 2.0 * work.disc->radius;
    const cv::Vec3d unit(1.0 / scale, 1.0 / scale, 2.0 / scale);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) outline.covariance(a, b) = fitted.covariance(a, b) * unit[a] * unit[b];
    assert(is_covariance(outline.covariance));
    outline.shared_diameter_sd_px = 2.0 * fitted.shared_radius_sd_px / scale;
    outline.visible_arcs = fitted.visible_arcs;
    outline.visible_fraction = fitted.visible_fraction;
    outline.rms_px = fitted.rms_px / scale;
    outline.blur_px = fitted.sigma_px / scale;
    outline.rise = fitted.shape.rise;
    return outline;
  }

  const Photograph& photograph_;
  const PlaneMap& map_;
  std::span<const Candidate> candidates_;
  OutlineSettings settings_;
  std::vector<Work> works_;
  std::optional<OvalModel> oval_model_;
};

}  // namespace

FittedOutlines fit_outlines(const Photograph& photograph, const PlaneMap& map,
                            std::span<const Candidate> candidates, const OutlineSettings& settings) {
  return OutlineFitter(photograph, map, candidates, settings).run();
}

}  // namespace strobe::digitize
