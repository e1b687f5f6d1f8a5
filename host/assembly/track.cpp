#include "host/assembly/track.hpp"

#include <algorithm>

namespace strobe::host {

double degrees_of_freedom(const Track& track) {
  double dof = 0.0;
  for (const Leg leg : {Leg::incoming, Leg::rebound}) {
    const auto count = std::ranges::count(track.images, leg, &TrackPoint::leg);
    dof += std::max(0.0, 2.0 * static_cast<double>(count) - 4.0);
  }
  return dof;
}

}  // namespace strobe::host
