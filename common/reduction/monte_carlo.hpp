// The uncertainty of one shot by Monte Carlo: all inputs are drawn from what is known of them, and the shot is fitted again,
// many times. Says whether the stated intervals, which rest on the law of propagation, are those of the draws.
// Deterministic from the seed; thread-safe; allocates; some 10 us a draw.
// Source: JCGM 101:2008 (GUM, supplement 1), 7 and 8.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/reduction/reduce.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

enum class Agreement {
  yes,   ///< both ends of the stated interval are within the tolerance of the draws'
  no,    ///< one is not, by more than what the draws leave open
  open,  ///< too few draws to tell
};

/// One quantity over the draws.
struct DrawnNumber {
  int draws = 0;  ///< that gave a number
  double mean = 0.0;
  double sd = 0.0;
  double low = 0.0, high = 0.0;  ///< 2.5 % of the draws are below, 2.5 % above
  /// Half a unit in the second significant digit of the stated standard uncertainty, or in the first where the draws are
  /// too few for two (JCGM 101, 7.9.2 and 8.1).
  double tolerance = 0.0;
  int digits = 2;
  double end_sd = 0.0;  ///< of low and high, from the number of draws; the larger
  Agreement agrees = Agreement::open;
};

struct MonteCarlo {
  int draws = 0;
  std::uint64_t seed = 0;
  std::array<std::optional<DrawnNumber>, kQuantityCount> quantities{};  ///< index: Quantity

  const std::optional<DrawnNumber>& of(Quantity q) const { return quantities[static_cast<std::size_t>(q)]; }
};

inline constexpr int kMinDraws = 1000;
inline constexpr int kMaxDraws = 10000000;

/// Noise that was stated is drawn from normal distributions, as are scale, map, ball and air; noise that was estimated from
/// Student's t, one factor for all that have the same estimate. Images, effects and weights stay those of the shot. Held
/// against expanded_uncertainty(). Fails as uncertainty_budget() does. `draws`: kMinDraws to kMaxDraws.
Result<MonteCarlo> monte_carlo(const Frame& frame, int draws, std::uint64_t seed,
                               Estimator estimator = Estimator::best, const ReduceOptions& options = {});

}  // namespace strobe::reduction
