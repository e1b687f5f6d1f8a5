#include "host/digitize/outliers/selection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/digitize/outliers/ball_size.hpp"
#include "host/digitize/outliers/ghosts.hpp"
#include "host/digitize/outliers/limb_agreement.hpp"
#include "host/digitize/outliers/spacing.hpp"
#include "host/digitize/path/path.hpp"

namespace strobe::digitize {
namespace {

// With fewer certain balls the size is taken from all outlines.
constexpr std::size_t kMinCertainBalls = 4;
// A less certain centre is that of a sliver at the border, or of arcs that belong to several things.
constexpr double kMaxSdOfDiameter = 0.004;
// Near the bounce, arcs of several balls are more likely to look like a ball in contact.
constexpr double kMaxContactSdOfDiameter = 0.002;
// What may be a ball by its limb or not must show a share of what could be seen of its outline: a third where it is
// hardly more than arcs of other things, which agree with a ball's limb there and by chance on a third of the rest
// (limb_agreement.hpp), and less the more likely a ball it is.
constexpr double kMinVisible = 1.0 / 3.0;
// On small balls half a px, which annotation and the coarse search are good to.
constexpr double kMinMaxSd_px = 0.5;

void reject(std::vector<Unmeasured>& rejected, const Outline& o, Reason reason, std::string detail) {
  rejected.push_back({o.centre, o.diameter, "image", {reason, std::move(detail)}});
}

double min_visible(const LimbAgreement& limb) {
  constexpr double kFrom = LimbAgreement::kNonBall, kTo = LimbAgreement::kBall;
  return kMinVisible * limb.observed * std::clamp((kTo - limb.agreement) / (kTo - kFrom), 0.0, 1.0);
}

std::vector<Outline> certain_balls(const std::vector<Outline>& outlines,
                                   const std::vector<LimbAgreement>& limbs) {
  std::vector<Outline> certain;
  for (std::size_t i = 0; i < outlines.size(); ++i)
    if (limbs[i].is_certain_ball()) certain.push_back(outlines[i]);
  return certain.size() < kMinCertainBalls ? outlines : certain;
}

/// The outlines that a path is searched through, with their limbs and places.
class PathSelection {
 public:
  PathSelection(std::vector<Outline> outlines, std::vector<LimbAgreement> limbs,
                const std::optional<SurfaceLine>& surface, const FlightFacts& facts,
                std::vector<Unmeasured>& rejected)
      : outlines_(std::move(outlines)),
        limbs_(std::move(limbs)),
        points_(path_points(outlines_, surface)),
        path_(
            find_path(points_, path_context(outlines_, surface, facts.ball_diameter_m, facts.flash_times_s))),
        keep_(outlines_.size(), true),
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

  /// Judged along the path only, where ambient light draws them.
  void reject_ghosts() {
    std::vector<int> members = path_.contact;
    for (const auto& leg : path_.legs) members.insert(members.end(), leg.begin(), leg.end());
    std::vector<LitDisc> discs;
    for (const int i : members) {
      const Outline& o = outlines_[static_cast<std::size_t>(i)];
      const LimbAgreement& limb = limbs_[static_cast<std::size_t>(i)];
      discs.push_back({o.centre, o.diameter, limb.limb, limb.is_certain_ball()});
    }
    for (const Ghost& ghost : find_ghosts(discs)) {
      const int index = members[static_cast<std::size_t>(ghost.index)];
      drop(index, Reason::ghost,
           fmt::format("its limb rises by {:.0f} % of the next ball's: ambient light between two flashes",
                       100.0 * ghost.share));
      for (auto& leg : path_.legs) std::erase(leg, index);
      std::erase(path_.contact, index);
    }
  }

  /// Neighbours on a line that the ball flies down and up may be of both ways.
  void reject_too_close(std::span<const double> flash_times_s) {
    if (path_.straight) return;
    std::vector<double> quality;
    for (const LimbAgreement& limb : limbs_) quality.push_back(limb.agreement);
    for (const TooClose& c : find_too_close(path_, points_, quality, flash_times_s))
      drop(c.index, Reason::duplicate,
           fmt::format("{:.1f} px from a better image: nearer than the ball's steps allow", c.distance_px));
  }

  void reject_imprecise_contacts() {
    for (const int i : path_.contact) {
      const auto at = static_cast<std::size_t>(i);
      const double sd = points_[at].sd_px;
      if (sd <= std::max(kMinMaxSd_px, kMaxContactSdOfDiameter * outlines_[at].diameter)) continue;
      if (limbs_[at].is_certain_ball()) continue;
      drop(i, Reason::imprecise,
           fmt::format("arcs near the surface that fix a centre to {:.1f} px only", sd));
    }
  }

  std::vector<Outline> selected() const {
    std::vector<Outline> result;
    for (std::size_t i = 0; i < outlines_.size(); ++i)
      if (keep_[i]) result.push_back(outlines_[i]);
    return result;
  }

 private:
  void drop(int index, Reason reason, std::string detail) {
    const auto at = static_cast<std::size_t>(index);
    keep_[at] = false;
    reject(rejected_, outlines_[at], reason, std::move(detail));
  }

  std::vector<Outline> outlines_;
  std::vector<LimbAgreement> limbs_;
  std::vector<PathPoint> points_;
  Path path_;
  std::vector<bool> keep_;
  std::vector<Unmeasured>& rejected_;
};

}  // namespace

std::vector<Outline> select_by_size(const Photograph& photograph, const PlaneMap& map,
                                    std::vector<Outline> outlines, const std::optional<SurfaceLine>& surface,
                                    std::vector<Unmeasured>& rejected) {
  if (outlines.empty()) return outlines;
  const auto limbs = compare_limbs(photograph, map, outlines, surface);
  const SizeModel size = fit_size_model(certain_balls(outlines, limbs));
  std::vector<Outline> selected;
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    Outline& o = outlines[i];
    const double sd = o.centre_sd();
    if (sd > std::max(kMinMaxSd_px, kMaxSdOfDiameter * o.diameter) &&
        (limbs[i].is_certain_non_ball() || o.visible_fraction < min_visible(limbs[i])))
      reject(rejected, o, Reason::imprecise, fmt::format("its centre would be known to {:.1f} px only", sd));
    else if (has_wrong_size(o, size) && !limbs[i].is_certain_ball())
      reject(
          rejected, o, Reason::wrong_size,
          fmt::format("{:.1f} px, where the ball's images agree on {:.1f}", o.diameter, size.at(o.centre.x)));
    else
      selected.push_back(std::move(o));
  }
  return selected;
}

std::vector<Outline> select_by_path(const Photograph& photograph, const PlaneMap& map,
                                    std::vector<Outline> outlines, const std::optional<SurfaceLine>& surface,
                                    const FlightFacts& facts, std::vector<Unmeasured>& rejected) {
  const auto limbs = compare_limbs(photograph, map, outlines, surface);
  std::vector<Outline> balls;
  std::vector<LimbAgreement> their_limbs;
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    if (limbs[i].is_certain_non_ball()) {
      reject(rejected, outlines[i], Reason::few_edges,
             fmt::format("light rises by {:.0f} % only of what it does across the others' outlines",
                         100.0 * limbs[i].agreement));
      continue;
    }
    if (!limbs[i].is_certain_ball() && outlines[i].visible_fraction < min_visible(limbs[i])) {
      reject(rejected, outlines[i], Reason::few_edges,
             fmt::format(
                 "its outline is clear over {:.0f} of 360 degrees only, and light rises by {:.0f} % of what "
                 "it does across the others' outlines",
                 360.0 * outlines[i].visible_fraction, 100.0 * limbs[i].agreement));
      continue;
    }
    their_limbs.push_back(limbs[i]);
    balls.push_back(std::move(outlines[i]));
  }
  if (balls.empty()) return balls;
  PathSelection selection(std::move(balls), std::move(their_limbs), surface, facts, rejected);
  selection.reject_off_path();
  selection.reject_ghosts();
  selection.reject_too_close(facts.flash_times_s);
  selection.reject_imprecise_contacts();
  return selection.selected();
}

}  // namespace strobe::digitize
