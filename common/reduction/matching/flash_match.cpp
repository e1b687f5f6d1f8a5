#include "common/reduction/matching/flash_match.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "common/reduction/consistency.hpp"
#include "common/reduction/matching/contact_match.hpp"
#include "common/reduction/matching/leg_candidates.hpp"

namespace strobe::matching {
namespace {

// An assignment whose flight alone is this much worse than the best has a negligible probability.
constexpr double kNegligible = 60.0;
constexpr double kFinite = std::numeric_limits<double>::max();
// -2 ln of 1/10: an assignment ten times less likely than the best is implausible.
constexpr double kImplausible = 4.6;

struct Legs {
  std::span<const TrackPoint> in, contact, out;
};

Legs split(const Track& track) {
  const auto is = [](Leg leg) { return [leg](const TrackPoint& image) { return image.leg == leg; }; };
  const auto& images = track.images;
  const auto n_in = static_cast<std::size_t>(std::count_if(images.begin(), images.end(), is(Leg::incoming)));
  const auto n_out = static_cast<std::size_t>(std::count_if(images.begin(), images.end(), is(Leg::rebound)));
  const std::span<const TrackPoint> all(images);
  return {all.first(n_in), all.subspan(n_in, all.size() - n_in - n_out), all.last(n_out)};
}

struct Pair {
  const LegCandidate* in;
  const LegCandidate* out;
  double chi_squared;
  double penalty;

  double score(double scale) const { return chi_squared / scale + penalty; }
};

double prior_penalty(const LegCandidate& in, const LegCandidate& out, std::span<const double> times_s,
                     const std::optional<ArrivalPrior>& prior) {
  if (!prior) return 0.0;
  double touchdown = prior->touchdown_s;
  if (in.crossing) {
    touchdown = in.crossing->time_s;
  } else if (out.crossing) {
    touchdown = out.crossing->time_s;
  } else if (!in.empty()) {
    touchdown = times_s[static_cast<std::size_t>(in.last())];
  } else if (!out.empty()) {
    touchdown = times_s[static_cast<std::size_t>(out.first())];
  }
  const double z = (touchdown - prior->touchdown_s) / prior->scale_s;
  return 2.0 * std::log1p(z * z);
}

/// Whether there are as many flashes from one image to the next, and the same images without one.
bool same_gaps(const std::vector<int>& a, const std::vector<int>& b) {
  for (std::size_t i = 1; i < a.size(); ++i) {
    const bool none = a[i] == kNoFlash || b[i] == kNoFlash;
    if (none ? a[i] != b[i] : a[i] - a[0] != b[i] - b[0]) return false;
  }
  return true;
}

/// Combines candidates of both legs into assignments of all images.
class Matcher {
 public:
  Matcher(std::span<const double> times_s, const Track& track, const std::optional<ArrivalPrior>& prior)
      : times_s_(times_s),
        track_(track),
        prior_(prior),
        legs_(split(track)),
        contact_(legs_.contact, times_s, track) {}

  FlashMatch run() {
    assert(legs_.in.size() + legs_.contact.size() + legs_.out.size() == track_.images.size());
    const auto in = leg_candidates(legs_.in, times_s_, track_);
    const auto out = leg_candidates(legs_.out, times_s_, track_);
    scale_ = noise_scale(lowest(in) + lowest(out));
    collect(in, out);
    if (pairs_.empty()) return in_order();
    return choose();
  }

 private:
  int flash_count() const { return static_cast<int>(times_s_.size()); }
  int contact_count() const { return static_cast<int>(legs_.contact.size()); }

  void collect(const std::vector<LegCandidate>& ins, const std::vector<LegCandidate>& outs) {
    pairs_.reserve(4 * ins.size());
    for (const LegCandidate& in : ins) {
      const int least = in.empty() ? contact_count() : in.last() + 1;
      auto out = std::lower_bound(outs.begin(), outs.end(), least, [](const LegCandidate& c, int first) {
        return !c.empty() && c.first() < first;
      });
      for (; out != outs.end(); ++out) {
        if (!in.empty() && !out->empty() && out->first() > least + contact_count() + track_.most_missed)
          break;
        consider(in, *out);
      }
    }
  }

  void consider(const LegCandidate& in, const LegCandidate& out) {
    const bool both = !in.empty() && !out.empty();
    if (out.empty() && !in.empty() && in.last() + contact_count() >= flash_count()) return;
    Pair pair{&in, &out, in.chi_squared + out.chi_squared, missed_penalty_ * (in.missed + out.missed)};
    if (both && is_negligible(pair, contact_.least_penalty(out.first() - in.last() - 1))) return;
    pair.penalty += prior_penalty(in, out, times_s_, prior_);
    if (in.crossing && out.crossing) pair.penalty += contact_penalty(estimate_bounce(in, out, track_));
    if (is_negligible(pair)) return;
    pair.penalty += contact_.match(in, out).penalty;
    if (is_negligible(pair)) return;
    best_score_ = std::min(best_score_, pair.score(scale_));
    pairs_.push_back(pair);
  }

  /// With a further penalty.
  bool is_negligible(const Pair& pair, double penalty = 0.0) const {
    return !(pair.score(scale_) + penalty <= std::min(best_score_ + kNegligible, kFinite));
  }

  /// Noise larger than stated shows in the best match's own residuals and makes the others less unlikely.
  /// What chance explains is not taken for it: weights would be too even, and the mixture too wide.
  double noise_scale(double chi_squared) const {
    constexpr double kStated = std::numeric_limits<double>::infinity();
    const double dof = degrees_of_freedom(track_);
    const bool explained = reduction::chance_of_scatter(chi_squared, dof, kStated) >= reduction::kFalseAlarms;
    return explained ? 1.0 : chi_squared / std::max(1.0, dof);
  }

  static double lowest(const std::vector<LegCandidate>& candidates) {
    double chi_squared = candidates.empty() ? 0.0 : candidates.front().chi_squared;
    for (const LegCandidate& c : candidates) chi_squared = std::min(chi_squared, c.chi_squared);
    return chi_squared;
  }

  const Pair& best(double scale) const {
    return *std::min_element(pairs_.begin(), pairs_.end(), [scale](const Pair& a, const Pair& b) {
      return a.score(scale) < b.score(scale);
    });
  }

  FlashMatch choose() {
    const double scale = noise_scale(best(scale_).chi_squared);
    std::ranges::sort(pairs_, [scale](const Pair& a, const Pair& b) {
      return std::pair(a.score(scale), order(a)) < std::pair(b.score(scale), order(b));
    });
    FlashMatch match;
    match.explained = scale == 1.0;
    match.hypotheses = likeliest(scale);
    match.chi_squared = pairs_.front().chi_squared;
    match.penalty = pairs_.front().penalty;
    match.misassignment_probability = 1.0 - 1.0 / total_weight(scale);
    match.possibly_imaged = possibly_imaged(pairs_.front(), scale);
    return match;
  }

  /// Of two as likely the earlier first, on every machine.
  static std::pair<int, int> order(const Pair& pair) {
    return {pair.in->empty() ? -1 : pair.in->first(), pair.out->empty() ? -1 : pair.out->first()};
  }

  /// In units of the likeliest one's.
  double weight(const Pair& pair, double scale) const {
    return std::exp(-0.5 * (pair.score(scale) - pairs_.front().score(scale)));
  }

  double total_weight(double scale) const {
    double all = 0.0;
    for (const Pair& pair : pairs_) all += weight(pair, scale);
    return all;
  }

  /// Without the patterns of gaps that are implausible together, such as an image in contact that nobody
  /// found, and of the others without the least likely hypotheses.
  std::vector<FlashAssignment> likeliest(double scale) {
    std::vector<FlashAssignment> all;
    std::vector<Pattern> patterns;
    std::vector<std::size_t> pattern;  // of each
    double total = 0.0;
    for (const Pair& pair : pairs_) {
      const double w = weight(pair, scale);
      if (w < kDroppedProbability / static_cast<double>(pairs_.size())) break;
      all.push_back({flashes_of(pair), w});
      pattern.push_back(pattern_of(all, patterns));
      patterns[pattern.back()].weight += w;
      total += w;
    }
    std::vector<FlashAssignment> hypotheses;
    double kept = 0.0;
    for (std::size_t i = 0; i < all.size() && kept < (1.0 - kDroppedProbability) * total; ++i) {
      if (patterns[pattern[i]].weight < kDroppedProbability * total) continue;
      kept += all[i].weight;
      hypotheses.push_back(std::move(all[i]));
    }
    for (FlashAssignment& hypothesis : hypotheses) hypothesis.weight /= kept;
    return hypotheses;
  }

  /// Hypotheses with as many flashes from one image to the next.
  struct Pattern {
    std::vector<int> flash;  ///< of one of them
    double weight = 0.0;
  };

  /// Of the last hypothesis; a new one if it is like none before.
  static std::size_t pattern_of(const std::vector<FlashAssignment>& all, std::vector<Pattern>& patterns) {
    const std::vector<int>& last = all.back().flash;
    const auto same =
        std::ranges::find_if(patterns, [&](const Pattern& one) { return same_gaps(one.flash, last); });
    const auto index = static_cast<std::size_t>(same - patterns.begin());
    if (same == patterns.end()) patterns.push_back({last});
    return index;
  }

  std::vector<int> flashes_of(const Pair& pair) {
    std::vector<int> flash;
    flash.reserve(track_.images.size());
    flash.insert(flash.end(), pair.in->flash.begin(), pair.in->flash.end());
    const auto& contact = contact_.match(*pair.in, *pair.out).flash;
    flash.insert(flash.end(), contact.begin(), contact.end());
    flash.insert(flash.end(), pair.out->flash.begin(), pair.out->flash.end());
    assert(flash.size() == track_.images.size());
    assert(is_ascending(flash));
    assert(flash.front() >= 0 && flash.back() < flash_count());
    return flash;
  }

  static bool is_ascending(std::vector<int> flash) {
    std::erase(flash, kNoFlash);
    return std::ranges::adjacent_find(flash, std::greater_equal<>()) == flash.end();
  }

  /// Where equal intervals leave the offset open, a flash next to the ball's may have been one of them.
  std::vector<char> possibly_imaged(const Pair& chosen, double scale) const {
    std::vector<char> marked(times_s_.size(), 0);
    for (const Pair& pair : pairs_) {
      if (pair.score(scale) - chosen.score(scale) > kImplausible) continue;
      if (pair.in->empty() && pair.out->empty()) continue;
      const int first = pair.in->empty() ? pair.out->first() : pair.in->first();
      const int last = pair.out->empty() ? pair.in->last() : pair.out->last();
      std::fill(marked.begin() + first, marked.begin() + last + 1, char{1});
    }
    return marked;
  }

  /// Consecutive flashes around the expected arrival, else around the middle of the exposure.
  FlashMatch in_order() const {
    const int count = static_cast<int>(track_.images.size());
    const double around = prior_ ? prior_->touchdown_s : 0.5 * (times_s_.front() + times_s_.back());
    const auto it = std::lower_bound(times_s_.begin(), times_s_.end(), around);
    const int middle = static_cast<int>(it - times_s_.begin());
    FlashMatch match;
    std::vector<int>& flash = match.hypotheses.front().flash;
    flash.resize(track_.images.size());
    std::iota(flash.begin(), flash.end(), std::clamp(middle - count / 2, 0, flash_count() - count));
    match.misassignment_probability = 1.0;
    match.explained = match.steady = false;
    return match;
  }

  std::span<const double> times_s_;
  const Track& track_;
  const std::optional<ArrivalPrior>& prior_;
  Legs legs_;
  ContactMatcher contact_;
  double missed_penalty_ = -2.0 * std::log(track_.missed_share);
  std::vector<Pair> pairs_;
  double scale_ = 1.0;
  double best_score_ = std::numeric_limits<double>::infinity();
};

// Images at any place between their neighbours are .29 of a step off steady flight; a lens that no
// calibration undoes bends it by hundredths.
constexpr double kUnsteadyOfStep = 0.12;

/// Median distance from an airborne image to the next.
double usual_step_px(const Track& track) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < track.images.size(); ++k) {
    const TrackPoint &a = track.images[k - 1], &b = track.images[k];
    if (a.leg == b.leg && b.leg != Leg::contact) steps.push_back((b.centre_px - a.centre_px).norm());
  }
  if (steps.empty()) return std::numeric_limits<double>::infinity();
  std::ranges::sort(steps);
  return 0.5 * (steps[(steps.size() - 1) / 2] + steps[steps.size() / 2]);
}

constexpr std::ptrdiff_t kMinLeft = 3;  // of a leg: two have no residual
// Of the interval: a velocity changes by as little.
constexpr double kSameShare = 0.005;

Track without(const Track& track, std::size_t image) {
  Track others = track;
  others.images.erase(others.images.begin() + static_cast<std::ptrdiff_t>(image));
  return others;
}

bool is_airborne(const TrackPoint& image) { return image.leg != Leg::contact; }

bool can_be_left_out(const Track& track, std::size_t image) {
  const Leg leg = track.images[image].leg;
  return leg == Leg::contact || std::ranges::count(track.images, leg, &TrackPoint::leg) > kMinLeft;
}

/// -2 ln of the likelihood, less what noise alone makes of it: so that one of fewer images in the air is not
/// preferred.
double beyond_expected(const Track& track, const FlashMatch& match) {
  const auto airborne = std::ranges::count_if(track.images, is_airborne);
  return match.chi_squared + match.penalty - 2.0 * static_cast<double>(airborne);
}

/// Whether the images but this one are of flashes at the same times after the first, as those of an even
/// train are but for microseconds.
bool is_as_before(std::span<const double> times_s, const FlashMatch& match, const FlashMatch& others,
                  std::size_t image) {
  std::vector<int> before = match.hypotheses.front().flash;
  before.erase(before.begin() + static_cast<std::ptrdiff_t>(image));
  const std::vector<int>& now = others.hypotheses.front().flash;
  const auto after_first = [&](const std::vector<int>& flash, std::size_t i) {
    return times_s[static_cast<std::size_t>(flash[i])] - times_s[static_cast<std::size_t>(flash[0])];
  };
  for (std::size_t i = 1, last = 0; i < now.size(); ++i) {
    if (now[i] == kNoFlash || before[i] == kNoFlash) continue;  // one that says nothing of the others
    const double step_s = after_first(now, i) - after_first(now, last);
    if (std::abs(after_first(now, i) - after_first(before, i)) > kSameShare * step_s) return false;
    last = i;
  }
  return true;
}

}  // namespace

bool gaps_agree(const FlashMatch& match) {
  return std::ranges::all_of(match.hypotheses, [&](const FlashAssignment& one) {
    return same_gaps(match.hypotheses.front().flash, one.flash);
  });
}

std::optional<FlashMatch> match_flashes(std::span<const double> times_s, const Track& track,
                                        const std::optional<ArrivalPrior>& prior) {
  assert(std::is_sorted(times_s.begin(), times_s.end()));
  if (times_s.size() < track.images.size()) return std::nullopt;
  if (track.images.empty()) return FlashMatch{};
  return Matcher(times_s, track, prior).run();
}

double degrees_of_freedom(const Track& track) {
  double dof = 0.0;
  for (const Leg leg : {Leg::incoming, Leg::rebound}) {
    const auto count = std::ranges::count(track.images, leg, &TrackPoint::leg);
    dof += std::max(0.0, 2.0 * static_cast<double>(count) - 4.0);
  }
  return dof;
}

double off_steady_px(const Track& track, const FlashMatch& match) {
  const double dof = degrees_of_freedom(track);
  if (!(dof > 0.0)) return 0.0;
  if (!match.steady) return std::numeric_limits<double>::infinity();
  return track.sd_px * std::sqrt(match.chi_squared / dof);
}

bool is_steady(const Track& track, const FlashMatch& match) {
  const double off = off_steady_px(track, match);
  return !(off > kUnsteadyOfStep * usual_step_px(track));
}

std::optional<FalseImage> find_false_image(std::span<const double> times_s, const Track& track,
                                           const std::optional<ArrivalPrior>& prior,
                                           const FlashMatch& match) {
  if (match.explained) return std::nullopt;
  std::optional<FalseImage> found;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < track.images.size(); ++i) {
    if (!can_be_left_out(track, i)) continue;
    const Track others = without(track, i);
    auto other_match = match_flashes(times_s, others, prior);
    if (!other_match || !other_match->steady || !other_match->explained) continue;
    const double d = beyond_expected(others, *other_match);
    if (!(d < least)) continue;
    least = d;
    found = FalseImage{i, std::move(*other_match)};
  }
  if (found && is_as_before(times_s, match, found->match, found->image)) return std::nullopt;
  return found;
}

}  // namespace strobe::matching
