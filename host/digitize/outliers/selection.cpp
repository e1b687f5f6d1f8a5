#include "host/digitize/outliers/selection.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>

#include "host/digitize/core/statistics.hpp"
#include "host/digitize/outliers/ball_odds.hpp"
#include "host/digitize/outliers/ghosts.hpp"
#include "host/digitize/outliers/limb_agreement.hpp"
#include "host/digitize/path/path.hpp"

namespace strobe::digitize {
namespace {

constexpr std::size_t kMinForSlope = 5;

double median_slope(std::span<const Outline> outlines) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    for (std::size_t j = i + 1; j < outlines.size(); ++j) {
      const double dx = outlines[j].centre.x - outlines[i].centre.x;
      if (std::abs(dx) < outlines[i].diameter) continue;
      slopes.push_back((outlines[j].diameter - outlines[i].diameter) / dx);
    }
  }
  return slopes.size() < kMinForSlope ? 0.0 : median(std::move(slopes));
}

double spread_about(std::span<const Outline> outlines, const SizeModel& size) {
  std::vector<double> off;
  for (const Outline& o : outlines) off.push_back(std::abs(o.diameter - size.at(o.centre.x)));
  return median(std::move(off));
}

SizeModel size_with_slope(std::span<const Outline> outlines, double slope) {
  std::vector<double> at_zero;
  for (const Outline& o : outlines) at_zero.push_back(o.diameter - slope * o.centre.x);
  return {median(std::move(at_zero)), slope, 0.0};
}

}  // namespace

SizeModel fit_size_model(std::span<const Outline> outlines) {
  assert(!outlines.empty());
  SizeModel size = size_with_slope(outlines, 0.0);
  double spread = spread_about(outlines, size);
  if (outlines.size() >= kMinForSlope) {
    const SizeModel sloped = size_with_slope(outlines, median_slope(outlines));
    const double less = spread_about(outlines, sloped);
    if (less < 0.5 * spread) {
      size = sloped;
      spread = less;
    }
  }
  std::vector<double> sds;
  for (const Outline& o : outlines) sds.push_back(o.diameter_sd());
  const double own = median(sds), all = kSdOverMad * spread;
  size.spread = std::sqrt(std::max(0.0, all * all - own * own));
  // 1.25: the error of a median against that of a mean.
  size.sd = 1.25 * std::max(kSdOverMad * spread, median(std::move(sds))) /
            std::sqrt(static_cast<double>(outlines.size()));
  return size;
}

namespace {

// More likely than not.
constexpr double kLikely = 0.5;
constexpr std::size_t kMinImages = 4;
constexpr double kCloseOfStep = 0.5;  // nearer to no step than to one
// Trains tell their flashes apart by unequal intervals: of their logarithms about the median's.
constexpr double kSdOfLogInterval = 0.65;
// Of the median interval, where the flashes' times are not known. An outline that near to another borrows
// most of its limb, and its probability.
const double kMinIntervalOfUnknown = std::exp(-kDoubtful_sd * kSdOfLogInterval);

/// What it adds that a step is so short, where the flashes' times are not known. What is no ball lies
/// anywhere between two: the log odds are of a log-normal density over an even one, alike where nothing is
/// said.
double log_odds_of_step(double of_median) {
  const double log_step = std::log(std::max(of_median, 1e-3));
  return std::min(0.0, -0.5 * log_step * log_step / (kSdOfLogInterval * kSdOfLogInterval) - log_step);
}

class PathLeg {
 public:
  PathLeg(std::vector<int> members, bool curved, std::span<const PathPoint> points,
          std::span<const double> probabilities)
      : members_(std::move(members)), curved_(curved), points_(points), probabilities_(probabilities) {}

  /// Shortest interval of two flashes or more over the median one.
  static double shortest_interval(std::span<const double> times_s) {
    std::vector<double> steps;
    for (std::size_t k = 1; k < times_s.size(); ++k) steps.push_back(times_s[k] - times_s[k - 1]);
    const double least = *std::min_element(steps.begin(), steps.end());
    return least / median(std::move(steps));
  }

  /// Removes the worse image of the closest pair. Returns nullopt if none is too close.
  /// `shortest_interval`: of the train, over its median.
  std::optional<TooClose> next(double shortest_interval, bool times_known) {
    if (members_.size() < kMinImages) return std::nullopt;
    const double typical = median_of([this](std::size_t k) { return step(k); });
    const double typical_distance = median_of([this](std::size_t k) { return distance(k); });
    std::optional<TooClose> nearest;
    for (std::size_t k = 1; k < members_.size(); ++k) {
      const double apart = step(k);
      if (apart >= kCloseOfStep * typical || (nearest && apart >= nearest->distance_px)) continue;
      const auto pair = worse_first(members_[k - 1], members_[k]);
      const bool impossible = apart < kCloseOfStep * shortest_interval * typical;
      // Gravity makes steps short along a curve, not across the picture; a toss goes across by next to
      // nothing.
      const double of_median = std::max(apart / typical, distance(k) / typical_distance);
      const double odds = times_known ? 0.0 : log_odds_of_step(of_median);
      const double p = probability_of(pair.first);
      if (!impossible && std::log(p / (1.0 - p)) + odds >= 0.0) continue;
      nearest = TooClose{pair.first, pair.second, apart};
    }
    if (nearest) std::erase(members_, nearest->index);
    return nearest;
  }

 private:
  double probability_of(int i) const { return probabilities_[static_cast<std::size_t>(i)]; }
  const PathPoint& at(int i) const { return points_[static_cast<std::size_t>(i)]; }
  cv::Point2d way(std::size_t k) const { return at(members_[k]).at - at(members_[k - 1]).at; }
  double distance(std::size_t k) const { return cv::norm(way(k)); }
  /// Gravity changes the speed along a curve, but not across the picture.
  double step(std::size_t k) const { return curved_ ? std::abs(way(k).x) : distance(k); }

  template <typename Step>
  double median_of(const Step& of) const {
    std::vector<double> steps;
    for (std::size_t k = 1; k < members_.size(); ++k) steps.push_back(of(k));
    return median(std::move(steps));
  }

  std::pair<int, int> worse_first(int a, int b) const {
    const bool a_worse = probability_of(a) != probability_of(b) ? probability_of(a) < probability_of(b)
                                                                : at(a).sd_px > at(b).sd_px;
    return a_worse ? std::pair(a, b) : std::pair(b, a);
  }

  std::vector<int> members_;
  bool curved_;
  std::span<const PathPoint> points_;
  std::span<const double> probabilities_;
};

}  // namespace

std::vector<TooClose> find_too_close(const Path& path, std::span<const PathPoint> points,
                                     std::span<const double> probabilities,
                                     std::span<const double> flash_times_s) {
  assert(points.size() == probabilities.size());
  // Along a curve the ball may be slow, or seen from above itself.
  const double unknown = path.curved ? 0.0 : kMinIntervalOfUnknown;
  const bool times_known = flash_times_s.size() >= 2;
  const double shortest_interval = times_known ? PathLeg::shortest_interval(flash_times_s) : unknown;
  std::vector<TooClose> too_close;
  for (const auto& members : path.legs) {
    PathLeg leg(members, path.curved, points, probabilities);
    while (const auto next = leg.next(shortest_interval, times_known)) too_close.push_back(*next);
  }
  return too_close;
}

namespace {

// With fewer certain balls the size is taken from all outlines.
constexpr std::size_t kMinCertainBalls = 4;
// A ball that is missed costs more than an image too many, which the reduction leaves out where it
// contradicts the others.
constexpr double kMinProbability = 0.1;

void reject(std::vector<Unmeasured>& rejected, const Outline& o, Reason reason, std::string detail) {
  rejected.push_back({o.centre, o.diameter, "image", {reason, std::move(detail)}});
}

std::vector<Outline> certain_balls(const std::vector<Outline>& outlines,
                                   const std::vector<LimbAgreement>& limbs) {
  std::vector<Outline> certain;
  for (std::size_t i = 0; i < outlines.size(); ++i)
    if (limbs[i].log_odds >= kCertainOdds) certain.push_back(outlines[i]);
  return certain.size() < kMinCertainBalls ? outlines : certain;
}

void reject_unlikely(std::vector<Unmeasured>& rejected, const Outline& o, const LimbAgreement& limb,
                     const SizeModel& size) {
  if (log_odds_of_size(o, size) < 0.0)
    reject(
        rejected, o, Reason::wrong_size,
        fmt::format("{:.1f} px, where the ball's images agree on {:.1f}", o.diameter, size.at(o.centre.x)));
  else
    reject(rejected, o, Reason::few_edges,
           fmt::format(
               "its outline is clear over {:.0f} of 360 degrees only, and light rises by {:.0f} % of what it "
               "does across the others' outlines",
               360.0 * o.visible_fraction, 100.0 * limb.agreement));
}

/// Whether its centre is in a likelier one, beside which there are arcs enough for it to be made of.
bool lies_on_likelier(std::size_t i, const std::vector<Outline>& outlines, const std::vector<double>& odds) {
  for (std::size_t j = 0; j < outlines.size(); ++j)
    if (odds[j] > odds[i] && cv::norm(outlines[j].centre - outlines[i].centre) < 0.5 * outlines[j].diameter)
      return true;
  return false;
}

/// That it is a ball's. On a likelier one neither the picture's other outlines nor the path count: both are
/// where the balls are whose arcs it may be made of.
struct Posterior {
  double probability = 0.0;
  bool accepted = false;
};

Posterior posterior_of(std::size_t i, const std::vector<Outline>& outlines, const std::vector<double>& odds,
                       const LimbAgreement& limb, const SizeModel& size, const Photograph& photograph,
                       const PlaneMap& map) {
  if (lies_on_likelier(i, outlines, odds)) {
    const double alone = probability(limb.log_odds + log_odds_of_size(outlines[i], size));
    return {alone, alone >= kLikely};
  }
  const double p = probability(odds[i] + log_odds_of_path(outlines[i], photograph, map));
  return {p, p >= kMinProbability};
}

std::vector<PathPoint> weighted_points(const std::vector<Outline>& outlines, const std::vector<double>& odds,
                                       const std::optional<SurfaceLine>& surface) {
  std::vector<PathPoint> points = path_points(outlines, surface);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].weight = probability(odds[i]);
  return points;
}

/// The outlines that a path is searched through, with their limbs and places.
class PathSelection {
 public:
  PathSelection(std::vector<Outline> outlines, std::vector<LimbAgreement> limbs, std::vector<double> odds,
                const std::optional<SurfaceLine>& surface, const FlightFacts& facts,
                std::vector<Unmeasured>& rejected)
      : outlines_(std::move(outlines)),
        limbs_(std::move(limbs)),
        odds_(std::move(odds)),
        points_(weighted_points(outlines_, odds_, surface)),
        context_(path_context(outlines_, surface, facts)),
        path_(find_path(points_, context_)),
        keep_(outlines_.size(), true),
        lit_(outlines_.size()),
        rejected_(rejected) {}

  void reject_off_path() {
    for (const Path::Outlier& outlier : path_.outliers) {
      if (outlier.below)
        drop(outlier.index, Reason::below_surface, "it lies below the surface");
      else if (outlier.doubled)
        drop(outlier.index, Reason::imprecise,
             "one outline of two images, of the way down and of the way up");
      else
        drop(outlier.index, Reason::off_path,
             std::isfinite(outlier.off_px) ? fmt::format("{:.1f} px off the ball's path", outlier.off_px)
                                           : std::string("no path leads to it"));
    }
  }

  /// One image is no path, and a line leads through any two.
  void take_back_odds_of_short_legs() {
    for (const auto& leg : path_.legs) {
      if (leg.size() > 2) continue;
      for (const int i : leg)
        outlines_[static_cast<std::size_t>(i)].probability = probability(odds_[static_cast<std::size_t>(i)]);
    }
  }

  /// Judged along the path only, where ambient light draws them.
  void reject_ghosts(const Photograph& photograph, const PlaneMap& map) {
    std::vector<int> members = path_.contact;
    for (const auto& leg : path_.legs) members.insert(members.end(), leg.begin(), leg.end());
    // Size and path say nothing: a ghost is of the ball's.
    std::vector<double> by_limb;
    for (const int i : members) by_limb.push_back(limbs_[static_cast<std::size_t>(i)].log_odds);
    const double prior = log_prior(by_limb);
    std::vector<LitDisc> discs;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const auto i = static_cast<std::size_t>(members[k]);
      discs.push_back({outlines_[i].centre, outlines_[i].diameter, limbs_[i].limb, by_limb[k] + prior});
    }
    // However bright the room may be.
    if (std::ranges::none_of(compare_light(discs, 1.0), &Lit::ghost)) return;
    for (std::size_t k = 0; const Lit& lit : compare_light(discs, std::nullopt))
      lit_[static_cast<std::size_t>(members[k++])] = lit;
    const auto level = ambient(photograph, map);
    for (std::size_t k = 0; const Lit& lit : compare_light(discs, level)) {
      const int index = members[k++];
      lit_[static_cast<std::size_t>(index)] = lit;
      if (!lit.ghost()) continue;
      drop(index, Reason::ghost,
           fmt::format("its limb rises by {:.0f} % of the next ball's: ambient light between two flashes",
                       100.0 * lit.share));
      for (auto& leg : path_.legs) std::erase(leg, index);
      std::erase(path_.contact, index);
    }
  }

  /// Neighbours on a line that the ball flies down and up may be of both ways.
  void reject_too_close(std::span<const double> flash_times_s) {
    if (path_.straight) return;
    std::vector<double> probabilities;
    for (const Outline& o : outlines_) probabilities.push_back(o.probability);
    for (const TooClose& c : find_too_close(path_, points_, probabilities, flash_times_s))
      drop(c.index, Reason::duplicate,
           fmt::format("{:.1f} px from a better image: nearer than the ball's steps allow", c.distance_px));
  }

  /// Near the surface arcs of several balls look like a ball in contact, to which no leg leads unless it is
  /// there only as the surface is hardly known.
  void reject_doubtful_contacts() {
    for (const int i : path_.contact) {
      const auto at = static_cast<std::size_t>(i);
      const bool led_to = !touches(points_[at].at.y, points_[at].sd_px, context_);
      if (!led_to) outlines_[at].probability = probability(odds_[at]);
      if (outlines_[at].probability < kLikely)
        drop(i, Reason::few_edges, "arcs near the surface, rather than a ball in contact");
    }
  }

  std::vector<Outline> selected() const {
    std::vector<Outline> result;
    for (std::size_t i = 0; i < outlines_.size(); ++i)
      if (keep_[i]) {
        Outline& o = result.emplace_back(outlines_[i]);
        o.probability = probability_beside_ghosts(o.probability, lit_[i]);
      }
    return result;
  }

 private:
  /// As the band that it draws between the images along a leg.
  std::optional<double> ambient(const Photograph& photograph, const PlaneMap& map) const {
    std::vector<ImageDisc> discs;
    std::vector<Flight> flights;
    const auto add = [&](const std::vector<int>& images, bool in_flight) {
      const std::size_t first = discs.size();
      for (const int i : images) {
        if (lit_[static_cast<std::size_t>(i)].ghost()) continue;
        discs.push_back(image_disc(map, outlines_[static_cast<std::size_t>(i)]));
        if (in_flight && discs.size() > first + 1) flights.push_back({discs.size() - 2, discs.size() - 1});
      }
    };
    for (const auto& leg : path_.legs) add(leg, true);
    add(path_.contact, false);
    return ambient_share(photograph, discs, flights);
  }

  void drop(int index, Reason reason, std::string detail) {
    const auto at = static_cast<std::size_t>(index);
    keep_[at] = false;
    reject(rejected_, outlines_[at], reason, std::move(detail));
  }

  std::vector<Outline> outlines_;
  std::vector<LimbAgreement> limbs_;
  std::vector<double> odds_;
  std::vector<PathPoint> points_;
  PathContext context_;
  Path path_;
  std::vector<bool> keep_;
  std::vector<Lit> lit_;
  std::vector<Unmeasured>& rejected_;
};

}  // namespace

SelectedBySize select_by_size(const Photograph& photograph, const PlaneMap& map,
                              std::vector<Outline> outlines, const std::optional<SurfaceLine>& surface,
                              std::vector<Unmeasured>& rejected) {
  if (outlines.empty()) return {};
  const auto limbs = compare_limbs(photograph, map, outlines, surface);
  SelectedBySize selected;
  selected.size = fit_size_model(certain_balls(outlines, limbs));
  const std::vector<double> odds = log_odds_of(outlines, limbs, selected.size);
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    Outline& o = outlines[i];
    if (probability(odds[i] + log_odds_of_path(o, photograph, map)) >= kMinProbability)
      selected.outlines.push_back(std::move(o));
    else
      reject_unlikely(rejected, o, limbs[i], selected.size);
  }
  return selected;
}

std::vector<Outline> select_by_path(const Photograph& photograph, const PlaneMap& map,
                                    std::vector<Outline> outlines, const std::optional<SurfaceLine>& surface,
                                    const FlightFacts& facts, std::vector<Unmeasured>& rejected) {
  if (outlines.empty()) return outlines;
  const auto limbs = compare_limbs(photograph, map, outlines, surface);
  const SizeModel size = fit_size_model(certain_balls(outlines, limbs));
  const std::vector<double> odds = log_odds_of(outlines, limbs, size);
  std::vector<Outline> balls;
  std::vector<LimbAgreement> their_limbs;
  std::vector<double> their_odds;
  std::vector<Posterior> posteriors;  // of each beside the others, all of which are still there
  for (std::size_t i = 0; i < outlines.size(); ++i)
    posteriors.push_back(posterior_of(i, outlines, odds, limbs[i], size, photograph, map));
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    outlines[i].probability = posteriors[i].probability;
    if (!posteriors[i].accepted) {
      reject_unlikely(rejected, outlines[i], limbs[i], size);
      continue;
    }
    outlines[i].moved_limb_px = moved_limb_px(outlines[i], size);
    their_limbs.push_back(limbs[i]);
    their_odds.push_back(odds[i]);
    balls.push_back(std::move(outlines[i]));
  }
  if (balls.empty()) return balls;
  PathSelection selection(std::move(balls), std::move(their_limbs), std::move(their_odds), surface, facts,
                          rejected);
  selection.reject_off_path();
  selection.take_back_odds_of_short_legs();
  selection.reject_ghosts(photograph, map);
  selection.reject_too_close(facts.times_s());
  selection.reject_doubtful_contacts();
  return selection.selected();
}

}  // namespace strobe::digitize
