// The readout of a frame of which several assignments of flashes to images are plausible.
// Deterministic, no I/O; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/result.hpp"

namespace strobe::host {

/// Times of a frame's images under one hypothesis about which flashes made them.
struct AssignedTimes {
  std::vector<double> time_s;  ///< of each image, from the first
  double weight = 1.0;         ///< its probability
};

/// The mixture over the hypotheses (common/reduction/mixture.hpp), of which the frame has the first one's times;
/// without any the frame's own readout, without Readout::assignments. Fails as reduce() does.
///
/// The flashes of an even train are alike but for microseconds, in which every number is as good as linear: hypotheses
/// alike in this way are reduced once, and the numbers of the others follow by the derivatives by the images' times
/// (Readout::by_time). So are the likeliest kMaxReduced that are not alike.
Result<reduction::Readout> reduce_hypotheses(const reduction::Frame& frame,
                                             std::span<const AssignedTimes> hypotheses);

/// More reductions are not made: a millisecond's work.
inline constexpr int kMaxReduced = 64;

}  // namespace strobe::host
