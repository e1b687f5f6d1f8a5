// The thesis's program, quirks and all, so that old results can be compared with new ones. Not for new work.
// Source: thesis, Appendix A. Its quirks: the tilt is applied with the wrong sign, which doubles it; the
// unwrap of the equator's angle is biased to topspin; path lengths count as positive even past the
// surface; 57.3 degrees to the radian and 3.1416 for pi. Pure functions; thread-safe; they allocate.
#pragma once

#include <array>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

/// One image as digitized: any length units.
struct LegacyImage {
  PointPx centre;
  PointPx edge;
  PointPx equator_1;
  PointPx equator_2;
};

struct LegacyFrame {
  double period_s = 0.0;  ///< nominal strobe period, > 0
  int contact_count = 0;  ///< flashes during contact, >= 0; as many as two of them are digitized
  int frame_number = 0;
  std::array<PointPx, 4> surface;     ///< 1, 2 on the touchdown side, 3, 4 on the lift-off side
  std::array<LegacyImage, 6> flight;  ///< 1-3 before the impact, 4-6 after, in order of time
  std::vector<LegacyImage> contact;   ///< 7, 8: the first two flashes in contact
};

/// Working diameter of the thesis. [m]
inline constexpr double kLegacyDiameter_m = 0.0651;

/// The program's numbers: `value` from images 2, 3 and 4, 5 ("near"), `legacy->far` from 1, 2 and 5, 6, and
/// the contact images. No standard deviations. Numbers that come out infinite or undefined are absent.
Readout reduce_legacy(const LegacyFrame& frame, double ball_diameter_m = kLegacyDiameter_m);

/// The same for a digitized frame: the three airborne images next to the impact on each side, the first two
/// contact images, surface points sorted from the touchdown side, and the median interval between images as
/// the period. Without four surface points or three airborne images a side the numbers are absent (flag
/// too_few_images).
Result<Readout> reduce_legacy(const Frame& frame);

/// The frame for the other estimators: times are whole periods, the contact count tells how many flashes lie
/// between.
Frame frame_from_legacy(const LegacyFrame& frame);

}  // namespace strobe::reduction
