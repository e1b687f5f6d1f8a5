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
/// The flashes of an even train are alike but for microseconds, in which every number is as good as linear: the
/// numbers of such hypotheses follow from the first one's and its derivatives by the images' times, a reduction each.
/// Where noise hides the microseconds the first one's numbers stand for all of these. The others are reduced
/// themselves, the likeliest kMaxReduced of them.
Result<reduction::Readout> reduce_hypotheses(const reduction::Frame& frame,
                                             std::span<const AssignedTimes> hypotheses);

/// More are not reduced one by one: a millisecond's work.
inline constexpr int kMaxReduced = 64;

}  // namespace strobe::host
