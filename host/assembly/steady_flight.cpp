#include "host/assembly/steady_flight.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "host/digitize/core/statistics.hpp"

namespace strobe::host {
namespace {

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
  return digitize::median(std::move(steps));
}

}  // namespace

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

}  // namespace strobe::host
