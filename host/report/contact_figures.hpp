// The images of the ball in contact, since touchdown: what Figures 4 to 17 are drawn from. Pure; thread-safe;
// allocates.
#pragma once

#include <optional>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"

namespace strobe::report {

struct ContactPoint {
  double time_s = 0.0;                 ///< since touchdown
  double x_m = 0.0;                    ///< the centre's way along the surface
  double drop_m = 0.0;                 ///< the top's height less that at touchdown; negative
  std::optional<double> rotation_rad;  ///< absent: no equator was seen
};

/// Of each image in contact whose top was measured. The frame has times; the readout is its. Touchdown is
/// where the incoming image next to it leads at the readout's velocity: within 3 ms gravity and air change
/// less than .05 mm. Empty where the readout lacks velocities, spins or the dwell time.
std::vector<ContactPoint> contact_points(const reduction::Frame& frame, const reduction::Readout& readout);

}  // namespace strobe::report
