#include "common/reduction/matching/leg_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/geometry/leg.hpp"

namespace strobe::matching {
namespace {

// How far the next image may be from where steady flight puts it, as a fraction of the step: a flash half a
// period off its neighbours' mean would be nearer to another image.
constexpr double kStepTolerance = 0.45;

/// Follows a leg from its first two flashes to the others, under known gravity. Allocates once.
class SteadyFlight {
 public:
  SteadyFlight(std::span<const TrackPoint> images, std::span<const double> times_s, const Track& track)
      : images_(images),
        times_s_(times_s),
        gravity_pxps2_(track.gravity_pxps2),
        most_missed_(track.most_missed),
        fit_(gravity_pxps2_) {
    flash_.reserve(images.size());
  }

  const std::vector<int>& flash() const { return flash_; }

  /// False if steady flight does not lead from these two to flashes.
  bool follow(int first, int second) {
    fit_ = geometry::LegFit(gravity_pxps2_);
    flash_.clear();
    add(first);
    add(second);
    while (flash_.size() < images_.size()) {
      const auto flash = next();
      if (!flash) return false;
      add(*flash);
      if (missed() > most_missed_) return false;
    }
    return true;
  }

 private:
  double time_s(int flash) const { return times_s_[static_cast<std::size_t>(flash)]; }
  int missed() const { return flash_.back() - flash_.front() + 1 - static_cast<int>(flash_.size()); }

  void add(int flash) {
    fit_.add(time_s(flash), images_[flash_.size()].centre_px);
    flash_.push_back(flash);
  }

  /// The flash after the last one at which the flight comes nearest to the next image; nullopt if not near.
  std::optional<int> next() const {
    const flight::Parabola path = fit_.path();
    const auto at = [&](int flash) { return path.position_at(time_s(flash) - fit_.mean_time_s()); };
    const Eigen::Vector2d& centre = images_[flash_.size()].centre_px;
    const int end = std::min(static_cast<int>(times_s_.size()), flash_.back() + 2 + most_missed_);
    std::optional<int> nearest;
    double least = std::numeric_limits<double>::infinity();
    for (int k = flash_.back() + 1; k < end; ++k) {
      const double off = (at(k) - centre).squaredNorm();
      if (!(off < least)) continue;
      least = off;
      nearest = k;
    }
    if (!nearest) return std::nullopt;
    const double step = (at(*nearest) - at(flash_.back())).squaredNorm();
    return least <= kStepTolerance * kStepTolerance * step ? nearest : std::nullopt;
  }

  std::span<const TrackPoint> images_;
  std::span<const double> times_s_;
  Eigen::Vector2d gravity_pxps2_;
  int most_missed_;
  geometry::LegFit fit_;
  std::vector<int> flash_;
};

struct Drift {
  Eigen::Vector2d acceleration_pxps2 = Eigen::Vector2d::Zero();
  /// Along and across the path: how well it is known.
  Eigen::Vector2d sd_pxps2 = Eigen::Vector2d::Zero();
};

/// Gravity and drag at the leg's mean velocity. A spin is not known here: the lift is anywhere between the
/// greatest of topspin and of backspin.
Drift drift_of(const Track& track, const Eigen::Vector2d& velocity_pxps) {
  Drift drift{track.gravity_pxps2, Eigen::Vector2d::Zero()};
  const double speed_mps = velocity_pxps.norm() / track.px_per_m;
  if (!(track.air.drag_per_m > 0.0) || !(speed_mps > 0.0)) return drift;
  const double drag = track.air.drag_mps2(speed_mps) * track.px_per_m;
  drift.acceleration_pxps2 -= drag * velocity_pxps.normalized();
  drift.sd_pxps2 = {track.air.law.drag_share_sd() * drag, track.air.law.greatest_lift() /
                                                              std::numbers::sqrt3 * track.air.lift_per_m *
                                                              speed_mps * speed_mps * track.px_per_m};
  return drift;
}

/// Squared residuals of both coordinates, along and across the path, over their variances: of the centres, of
/// the flashes' times along the path, and of the acceleration, which bends all of a leg's images together.
/// The last is an unknown with a prior (Koch, Parameter Estimation and Hypothesis Testing, 3.2).
double chi_squared(std::span<const TrackPoint> images, std::span<const double> times_s,
                   std::span<const int> flash, const geometry::LegFit& fit, const Track& track,
                   const Eigen::Vector2d& acceleration_sd) {
  if (!fit.has_velocity()) return 0.0;
  const flight::Parabola path = fit.path();
  const double speed = path.velocity.norm();
  const Eigen::Vector2d along =
      speed > 0.0 ? Eigen::Vector2d(path.velocity / speed) : Eigen::Vector2d(1.0, 0.0);
  const auto time = [&](std::size_t i) {
    return times_s[static_cast<std::size_t>(flash[i])] - fit.mean_time_s();
  };
  geometry::LinearRegression<double> bow;  // what of t^2/2 no line takes up
  for (std::size_t i = 0; i < images.size(); ++i)
    bow.add(time(i), 0.5 * time(i) * time(i), 1.0 / images[i].variance_share);
  double sum = 0.0;
  Eigen::Vector2d bent = Eigen::Vector2d::Zero(), stiff = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Eigen::Vector2d r = images[i].centre_px - path.position_at(time(i));
    const Eigen::Vector2d residual{along.dot(r), along.x() * r.y() - along.y() * r.x()};
    const double across = track.sd_px * track.sd_px * images[i].variance_share;
    const double by_time = speed * track.time_sd_s;
    const Eigen::Vector2d weight{1.0 / (across + by_time * by_time), 1.0 / across};
    const double b = 0.5 * time(i) * time(i) - bow.at(time(i));
    sum += weight.dot(residual.cwiseAbs2());
    bent += b * weight.cwiseProduct(residual);
    stiff += b * b * weight;
  }
  for (int k = 0; k < 2; ++k) {
    const double variance = acceleration_sd[k] * acceleration_sd[k];
    sum -= variance * bent[k] * bent[k] / (1.0 + variance * stiff[k]);
  }
  return sum;
}

LegCandidate candidate(std::span<const TrackPoint> images, std::span<const double> times_s,
                       const Track& track, const std::vector<int>& flash) {
  LegCandidate result;
  const auto at = [&](int k) { return times_s[static_cast<std::size_t>(k)]; };
  Drift drift{track.gravity_pxps2, Eigen::Vector2d::Zero()};
  if (images.size() > 1) {
    const Eigen::Vector2d way = images.back().centre_px - images.front().centre_px;
    drift = drift_of(track, way / (at(flash.back()) - at(flash.front())));
  }
  result.fit = geometry::LegFit(drift.acceleration_pxps2);
  for (std::size_t i = 0; i < images.size(); ++i)
    result.fit.add(at(flash[i]), images[i].centre_px, 1.0 / images[i].variance_share);
  result.chi_squared = chi_squared(images, times_s, flash, result.fit, track, drift.sd_pxps2);
  if (track.surface_known) {
    const int nearest = images.front().leg == Leg::incoming ? flash.back() : flash.front();
    result.crossing = geometry::crossing(result.fit, track.radius_px, at(nearest));
  }
  result.missed = flash.back() - flash.front() + 1 - static_cast<int>(flash.size());
  result.flash = flash;
  return result;
}

}  // namespace

std::vector<LegCandidate> leg_candidates(std::span<const TrackPoint> images, std::span<const double> times_s,
                                         const Track& track) {
  if (images.empty()) return {LegCandidate{}};
  std::vector<LegCandidate> candidates;
  candidates.reserve(2 * times_s.size());
  const int count = static_cast<int>(times_s.size());
  SteadyFlight flight(images, times_s, track);
  for (int first = 0; first < count; ++first) {
    if (images.size() == 1) {
      candidates.push_back(candidate(images, times_s, track, {first}));
      continue;
    }
    for (int second = first + 1; second <= first + 1 + track.most_missed && second < count; ++second) {
      if (flight.follow(first, second))
        candidates.push_back(candidate(images, times_s, track, flight.flash()));
    }
  }
  return candidates;
}

}  // namespace strobe::matching
