// One readout of several hypotheses about a photograph, of which only one is true: which flashes made its
// images. Deterministic, no I/O; thread-safe; allocates.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/reduction/uncertainty.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

/// What the photograph says under one hypothesis, or under several whose sds are the same.
struct MixtureComponent {
  Quantities value;
  Quantities sd;  ///< statistical
  Quantities sd_systematic;
  std::optional<Regime> regime;
  double weight = 1.0;  ///< probability; of all hypotheses together above 0
  int hypotheses = 1;
  std::array<double, kQuantityCount>
      between{};  ///< variance between them, index Quantity; `value` is their mean
};

/// The mixture: each number becomes the hypotheses' mean, its variance the mean of their variances plus the
/// variance between their values (law of total variance), sd_systematic the root mean square. Only hypotheses
/// that have a number count for it, and a number that the likeliest lacks stays null. Effective degrees of
/// freedom grow, as the variance between hypotheses is known (Welch, Satterthwaite). A regime that hypotheses
/// of more than 1 in 20 contradict is unclear. `likeliest`: of the first hypothesis; keeps all else. Sets
/// Readout::assignments and the flag flash_match_ambiguous where mixture_ambiguous(). The covariance of the
/// primary numbers is left out.
/// Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, 1.4.16.
void mix(std::span<const MixtureComponent> hypotheses, Readout& likeliest);

/// Whether the variance between the hypotheses exceeds that within them for some number: its sd is then more
/// than 41 % larger. Two equally likely normal densities have two peaks from there on (Eisenberger,
/// Technometrics 6, 1964): a mean and an sd no longer describe them.
bool mixture_ambiguous(const Readout& mixture);

/// Times of a frame's images under one hypothesis about which flashes made them.
struct AssignedTimes {
  std::vector<double> time_s;  ///< of each image, from the first
  double weight = 1.0;         ///< its probability
};

/// More reductions are not made: a millisecond's work.
inline constexpr int kMaxReduced = 64;

/// The mixture over the hypotheses, of which the frame has the first one's times; without any the frame's own
/// readout, without Readout::assignments. Fails as reduce() does.
///
/// The flashes of an even train are alike but for microseconds, in which every number is as good as linear:
/// hypotheses alike in this way are reduced once, and the numbers of the others follow by the derivatives by
/// the images' times (Readout::by_time). So are the likeliest kMaxReduced that are not alike.
Result<Readout> reduce_hypotheses(const Frame& frame, std::span<const AssignedTimes> hypotheses);

/// The uncertainty budget of the mixture: of the likeliest assignment of flashes to images, of which the
/// frame has the times, with a line for the others. Of plausible ones there are more than one only where they
/// are nearly alike, so that the other lines are those of all, scaled to the mixture's variance. Empty for a
/// frame without images or that cannot be reduced. Some milliseconds.
Budget mixture_budget(const Frame& frame, const Readout& mixture);

}  // namespace strobe::reduction
