#include "common/reduction/likely_cause.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/reduction/consistency.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Beyond any photograph: what a frame may state overflows.
constexpr double kAbsurdMisfit = 1e9;

double squared(double x) { return x * x; }

double of_images(const ShotFit& fit) {
  const Observations& all = fit.observations;
  const geometry::Rotation2d tilt = tilt_of(fit.joint);
  double sum = 0.0;
  for (const Observation& o : all.images) {
    if (o.use_diameter)
      sum += squared((o.diameter_m - fit.joint.unknowns[kScale] * all.ball_diameter_m) / all.diameter_sd(o));
    if (!o.use_centre || !fit.joint.legs[leg_index(*o.leg)].fitted) continue;
    const ImageRows rows = image_rows(all, fit.joint, tilt, o);
    sum += squared(rows.residual[0]) + squared(rows.residual[1]);
  }
  return sum;
}

/// Chi squared of all that the paths were fitted to: measurements, and what was known before.
double misfit(const ShotFit& fit) {
  if (fit.joint.degenerate()) return kInfinity;
  const Observations& all = fit.observations;
  double sum = of_images(fit);
  if (all.scale && !all.scale_exact())
    sum += squared((*all.scale - fit.joint.unknowns[kScale]) / all.scale_sd);
  sum += all.has_surface() ? surface_square_sum(fit) / squared(all.surface_sd())
                           : squared(fit.joint.unknowns[kTilt] / kCameraRollSd_rad);
  for (std::size_t p = 0; p < kAirErrorCount; ++p) {
    const AirError& prior = fit.air_fit.prior[p];
    if (prior.sd > 1e-12 && prior.sd < 1e12) sum += squared((fit.air_fit.value[p] - prior.mean) / prior.sd);
  }
  return sum;
}

struct Candidate {
  double step;                                 ///< some sds of what a photograph tells
  double farthest;                             ///< either way
  void (*move)(Observations& all, double by);  ///< from what was stated
};

/// Index: Cause.
constexpr std::array<Candidate, kCauseCount> kCandidates{
    {{0.2, 4.0, [](Observations& all, double by) { all.air_density_kgpm3 *= 1.0 + by; }},
     {0.002, 0.5,
      [](Observations& all, double by) {
        if (all.scale) *all.scale *= 1.0 + by;
      }},
     {0.002, 0.5,
      [](Observations& all, double by) {
        all.ball_diameter_m *= 1.0 + by;
        all.ball.diameter_m *= 1.0 + by;
      }},
     {0.002, 0.5,
      [](Observations& all, double by) {
        all.gravity_mps2 = geometry::Rotation2d(all.surface.mirrored ? by : -by) * all.gravity_mps2;
      }},
     {0.002, 0.5, [](Observations& all, double by) {
        for (Observation& o : all.images) o.time_s *= 1.0 + by;
      }}}};

constexpr Candidate kGravity{0.02, 10.0, [](Observations& all, double by) { all.gravity_mps2 *= 1.0 + by; }};

ShotFit moved(const ShotFit& fit, const Candidate& candidate, double by) {
  ShotFit other = fit;
  candidate.move(other.observations, by);
  refit(other, fit.effects);
  return other;
}

struct Explanation {
  double by = 0.0, sd = 0.0;
  double misfit = kInfinity;
};

/// Chance passes it once in 100,000, and there are five causes.
constexpr double kSignificant = 19.5;
constexpr double kIndistinguishableCauses = 9.0;

/// Steps to the least of the parabola through three misfits, which is one of any parameter that moves the
/// images in proportion. No further than the first where that promises to explain less than `worthwhile`.
Explanation explained_by(const ShotFit& fit, const Candidate& candidate, double worthwhile) {
  constexpr int kSteps = 4;
  constexpr double kTold = 1e-6;  // less is rounding
  const auto at = [&](double by) { return misfit(moved(fit, candidate, by)); };
  Explanation best;
  for (int step = 0; step < kSteps; ++step) {
    const double here = at(best.by);
    const double below = at(best.by - candidate.step), above = at(best.by + candidate.step);
    if (!(std::max({here, below, above}) < kAbsurdMisfit)) return {};
    const double bend = above - 2.0 * here + below;
    if (!(bend > kTold)) return {};
    best.misfit = here;
    best.sd = candidate.step * std::sqrt(2.0 / bend);
    const double slope = 0.5 * (above - below);
    if (step == 0 && 0.5 * slope * slope / bend < worthwhile) break;
    if (step + 1 == kSteps) break;
    best.by = std::clamp(best.by - candidate.step * slope / bend, -candidate.farthest, candidate.farthest);
  }
  return best;
}

/// With the image left out that lets the others agree best.
double least_without_one(const ShotFit& fit) {
  double least = kInfinity;
  for (std::size_t i = 0; i < fit.observations.images.size(); ++i) {
    if (!fit.observations.images[i].use_centre) continue;
    ShotFit other = fit;
    Observation& o = other.observations.images[i];
    o.use_centre = o.use_diameter = o.use_equator = false;
    refit(other, fit.effects);
    least = std::min(least, misfit(other));
  }
  return least;
}

LikelyCause named(Cause cause, const Explanation& by) {
  switch (cause) {
    case Cause::air:
      return {cause, 1.0 + by.by, by.sd};
    case Cause::inclination:
      return {cause, degrees(by.by), degrees(by.sd)};
    default:
      return {cause, 100.0 * by.by, 100.0 * by.sd};
  }
}

}  // namespace

std::optional<LikelyCause> likely_cause(const ShotFit& fit) {
  if (std::ranges::any_of(fit.variance_components, [](const VarianceComponent& c) { return c.used; }))
    return std::nullopt;
  const double as_stated = misfit(fit);
  if (!(as_stated < kAbsurdMisfit)) return std::nullopt;
  std::array<Explanation, kCauseCount> all;
  std::ranges::transform(kCandidates, all.begin(), [&](const Candidate& c) {
    return explained_by(fit, c, kSignificant - kIndistinguishableCauses);
  });
  const auto best = std::ranges::min_element(all, {}, &Explanation::misfit);
  if (!(best->misfit + kSignificant < as_stated)) return std::nullopt;
  const double told = best->misfit + kIndistinguishableCauses;
  const auto rivals = std::ranges::count_if(all, [&](const Explanation& e) { return e.misfit < told; });
  if (rivals > 1 || least_without_one(fit) < told) return std::nullopt;
  const auto cause = static_cast<std::size_t>(best - all.begin());
  const ShotFit explained = moved(fit, kCandidates[cause], best->by);
  if (test_residuals(explained).exceeded || scale_contradicts_ball(explained)) return std::nullopt;
  return named(static_cast<Cause>(cause), *best);
}

std::optional<Estimate> local_gravity(ShotFit fit) {
  Observations& all = fit.observations;
  if (all.scale) all.scale_sd = 0.0;
  refit(fit, {});
  const double stated_mps2 = all.gravity_mps2.norm();
  const Explanation free = explained_by(fit, kGravity, 0.0);
  if (!(free.sd > 0.0) || !std::isfinite(free.misfit)) return std::nullopt;
  return Estimate{stated_mps2 * (1.0 + free.by), stated_mps2 * free.sd};
}

}  // namespace strobe::reduction
