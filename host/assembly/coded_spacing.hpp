// Intervals by which a train names its flashes: images on a photograph tell which flashes made them.
//
// Images of a leg in steady flight leave its position and velocity open, so that only what their times have
// beside a straight line tells flashes apart. Of three images, the fewest of which anything is left, that is
// the change from one interval to the next. Intervals are the period and a whole number of steps more, the
// numbers such that no two places of the train have the same change in both legs, however many flashes the
// contact takes between them; the step is long enough that the images see the difference of one. No interval
// is shorter than the period: images overlap no more and lamps recharge as long as in the even train.
// Source: greedy construction as of Conway and Sloane, Lexicographic codes, IEEE Trans. Inf. Theory 32
// (1986). Deterministic, no I/O; thread-safe; allocates.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/reduction/matching/track.hpp"
#include "common/result.hpp"
#include "host/config/plan_file.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::host {

/// What the images can tell.
struct SpacingNoise {
  /// Of a coordinate of a centre, as a share of the ball's diameter; > 0.
  double centre_sd_of_diameter = 0.0;
  double flash_time_sd_s = 0.0;
  matching::DwellLimits contact{};  ///< of the ball
};

/// Intervals between `flashes` flashes, in order. Fails, for a person, where no code of so many flashes
/// exists whose intervals are long enough to be told apart and short enough that no photograph loses more
/// than an image in twelve.
Result<std::vector<Duration>> coded_intervals(Duration period, std::size_t flashes,
                                              const SpacingNoise& noise);

struct SpacedPlan {
  PlanFile plan;
  /// Which train it became and why, for a person; empty where the plan says it by itself.
  std::string remark;
  /// Why it cannot work, and what would, for a person; empty: it may.
  std::string problem{};
};

/// The plan with the intervals that Spacing::coded stands for, else as it is; even where no code is possible.
/// digitized: photographs are measured by the digitizer, not by hand.
SpacedPlan spaced_plan(const PlanFile& plan, const RigFile& rig, bool digitized);

}  // namespace strobe::host
