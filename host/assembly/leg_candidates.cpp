#include "host/assembly/leg_candidates.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::host {
namespace {

// How far the next image may be from where steady speed puts it, as a fraction of the step: a flash half a
// period off its neighbours' mean would be nearer to another image.
constexpr double kStepTolerance = 0.45;

double distance(const TrackPoint& a, const TrackPoint& b) { return (a.centre_px - b.centre_px).norm(); }

/// The number of the flash nearest to the time, after the given one; nullopt past the end.
std::optional<int> nearest_after(std::span<const double> times_s, int after, double time_s) {
  const auto begin = times_s.begin() + after + 1;
  if (begin == times_s.end()) return std::nullopt;
  auto it = std::lower_bound(begin, times_s.end(), time_s);
  if (it == times_s.end() || (it != begin && time_s - *(it - 1) < *it - time_s)) --it;
  return static_cast<int>(it - times_s.begin());
}

/// The flashes that follow when the leg starts with these two; empty if steady speed does not lead to
/// flashes.
std::vector<int> follow(std::span<const TrackPoint> images, std::span<const double> times_s, int first,
                        int second) {
  const auto at = [&](int k) { return times_s[static_cast<std::size_t>(k)]; };
  std::vector<int> flash;
  flash.reserve(images.size());
  flash.push_back(first);
  flash.push_back(second);
  double path = distance(images[0], images[1]);
  int missed = second - first - 1;
  for (std::size_t i = 2; i < images.size(); ++i) {
    const double step = distance(images[i - 1], images[i]);
    const double predicted = step * (at(flash.back()) - at(first)) / path;
    const auto next = nearest_after(times_s, flash.back(), at(flash.back()) + predicted);
    if (!next || !std::isfinite(predicted)) return {};
    if (std::abs(at(*next) - at(flash.back()) - predicted) > kStepTolerance * predicted) return {};
    missed += *next - flash.back() - 1;
    if (missed > kMaxMissed) return {};
    flash.push_back(*next);
    path += step;
  }
  return flash;
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
  result.crossing = geometry::crossing(result.fit, track.radius_px);
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
      std::vector<int> flash = follow(images, times_s, first, second);
      if (!flash.empty()) candidates.push_back(candidate(images, times_s, track, std::move(flash)));
    }
  }
  return candidates;
}

}  // namespace strobe::host
