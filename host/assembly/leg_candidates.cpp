#include "host/assembly/leg_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace strobe::host {
namespace {

// How far the next image may be from where steady flight puts it, as a fraction of the step: a flash half a
// period off its neighbours' mean would be nearer to another image.
constexpr double kStepTolerance = 0.45;

/// Flight at known flashes under known gravity, whose next image is looked for.
class SteadyFlight {
 public:
  SteadyFlight(std::span<const TrackPoint> images, std::span<const double> times_s, const Track& track)
      : images_(images), times_s_(times_s), fit_(track.gravity_pxps2) {}

  const std::vector<int>& flash() const { return flash_; }
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
    const int end = std::min(static_cast<int>(times_s_.size()), flash_.back() + 2 + kMaxMissed);
    std::optional<int> nearest;
    double least = std::numeric_limits<double>::infinity();
    for (int k = flash_.back() + 1; k < end; ++k) {
      const double off = (at(k) - centre).norm();
      if (!(off < least)) continue;
      least = off;
      nearest = k;
    }
    if (!nearest) return std::nullopt;
    const double step = (at(*nearest) - at(flash_.back())).norm();
    return least <= kStepTolerance * step ? nearest : std::nullopt;
  }

 private:
  double time_s(int flash) const { return times_s_[static_cast<std::size_t>(flash)]; }

  std::span<const TrackPoint> images_;
  std::span<const double> times_s_;
  geometry::LegFit fit_;
  std::vector<int> flash_;
};

/// The flashes that follow when the leg starts with these two; empty if steady flight does not lead to
/// flashes.
std::vector<int> follow(std::span<const TrackPoint> images, std::span<const double> times_s,
                        const Track& track, int first, int second) {
  SteadyFlight flight(images, times_s, track);
  flight.add(first);
  flight.add(second);
  while (flight.flash().size() < images.size()) {
    const auto next = flight.next();
    if (!next) return {};
    flight.add(*next);
    if (flight.missed() > kMaxMissed) return {};
  }
  return flight.flash();
}

/// Of both coordinates, in units of the noise.
double chi_squared(std::span<const TrackPoint> images, std::span<const double> times_s,
                   std::span<const int> flash, const geometry::LegFit& fit, double sd_px) {
  if (!fit.has_velocity()) return 0.0;
  const flight::Parabola path = fit.path();
  double sum = 0.0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const double dt = times_s[static_cast<std::size_t>(flash[i])] - fit.mean_time_s();
    sum += (images[i].centre_px - path.position_at(dt)).squaredNorm();
  }
  return sum / (sd_px * sd_px);
}

LegCandidate candidate(std::span<const TrackPoint> images, std::span<const double> times_s,
                       const Track& track, std::vector<int> flash) {
  LegCandidate result;
  result.fit = geometry::LegFit(track.gravity_pxps2);
  for (std::size_t i = 0; i < images.size(); ++i)
    result.fit.add(times_s[static_cast<std::size_t>(flash[i])], images[i].centre_px);
  result.chi_squared = chi_squared(images, times_s, flash, result.fit, track.sd_px);
  if (track.surface_known) {
    const int nearest = images.front().leg == Leg::incoming ? flash.back() : flash.front();
    result.crossing =
        geometry::crossing(result.fit, track.radius_px, times_s[static_cast<std::size_t>(nearest)]);
  }
  result.missed = flash.back() - flash.front() + 1 - static_cast<int>(flash.size());
  result.flash = std::move(flash);
  return result;
}

}  // namespace

std::vector<LegCandidate> leg_candidates(std::span<const TrackPoint> images, std::span<const double> times_s,
                                         const Track& track) {
  if (images.empty()) return {LegCandidate{}};
  std::vector<LegCandidate> candidates;
  candidates.reserve(2 * times_s.size());
  const int count = static_cast<int>(times_s.size());
  for (int first = 0; first < count; ++first) {
    if (images.size() == 1) {
      candidates.push_back(candidate(images, times_s, track, {first}));
      continue;
    }
    for (int second = first + 1; second <= first + 1 + kMaxMissed && second < count; ++second) {
      std::vector<int> flash = follow(images, times_s, track, first, second);
      if (!flash.empty()) candidates.push_back(candidate(images, times_s, track, std::move(flash)));
    }
  }
  return candidates;
}

}  // namespace strobe::host
