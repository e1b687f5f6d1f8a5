// The uncertainty of one shot's numbers, as the Guide to the expression of uncertainty in measurement (JCGM
// 100:2008, GUM, and its supplement JCGM 101) has it: what can be stated beside a number, the budget of its
// sources, and Monte Carlo as a check of both. Thread-safe; deterministic.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/reduction/reduce.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

inline constexpr double kExpandedLevel = 0.95;

/// Noise and what tolerances add, as one standard deviation. Absent without an sd.
std::optional<double> total_sd(const Numbers& numbers, Quantity quantity);

/// Half width of the interval that holds the true number with a probability of kExpandedLevel: noise, with
/// Student's t where it was estimated, and what tolerances add. Of few residuals it is far more than twice
/// the sd, which holds 68.27 %. nullopt without an sd, as with estimator "legacy".
/// Source: JCGM 100:2008 (GUM), 6.2.1 and G.4.
std::optional<double> expanded_uncertainty(const Numbers& numbers, Quantity quantity);

/// GUM's evaluation: from scatter, or by other means.
enum class EvaluationType { a, b };

enum class Source {
  centres,        ///< digitizing them, likewise the next three
  diameters,      //
  equators,       //
  surface,        //
  flash_times,    ///< where they state an sd
  unknown_spin,   ///< the lift of a spin that may be another, or that was not read
  assignment,     ///< which flash made which image, see mixture.hpp
  scale,          ///< the calibrated one's
  map,            ///< one of the calibration's independent errors
  ball_diameter,  ///< its tolerance, where the frame states it
  all_diameters,  ///< what they are off alike, likewise
  drag,           ///< tolerance of the drag coefficient
  lift_incoming,  ///< of the lift coefficient
  lift_rebound,   //
  spin_decay,     ///< of the spin's decay in flight
};
inline constexpr std::size_t kSourceCount = 15;

/// Whether all shots with the same rig, ball and calibration share its error.
constexpr bool is_shared(Source source) { return source >= Source::scale; }
/// Whether it is the calibration's, not the ball's.
constexpr bool is_calibration(Source source) { return source == Source::scale || source == Source::map; }
/// Whether it is in Readout::sd_systematic; the others are in Readout::sd.
constexpr bool is_systematic(Source source) { return source >= Source::ball_diameter; }

/// What one source does to all numbers of a shot.
struct BudgetSource {
  Source source = Source::centres;
  int number = 0;  ///< of several of the kind, from 1; 0: there is one
  EvaluationType type = EvaluationType::b;
  double input_sd = 0.0;          ///< of a source that is one input; 0: it is many
  std::string_view input_unit{};  ///< "%", "mm" ...
  /// Where its noise was estimated; absent: infinitely many. Sources with the same factor have the same
  /// estimate.
  std::optional<double> degrees_of_freedom{};
  int factor = -1;
  /// One standard deviation's, in the number's unit; index: Quantity; 0 where the number is absent. Of one
  /// input with the sign of a larger input; of many the root of the sum of squares.
  std::array<double, kQuantityCount> effect{};

  double of(Quantity q) const { return effect[static_cast<std::size_t>(q)]; }
};

/// By how much each source moves each number, by the law of propagation. The numbers are computed again with
/// each input moved a little either way, so that the budget does not rest on the covariance that the fit
/// states: the squares of its lines sum up to sd and sd_systematic, or one of both is wrong.
/// Source: JCGM 100:2008 (GUM), 5.1 and F.1.2; the differences: its 5.1.3, note 2.
struct Budget {
  std::vector<BudgetSource> sources;  ///< in the order of Source; those without any effect are left out
  /// Of the numbers, by all that this shot shares with no other; by SourceChoice::shared zero. Indices:
  /// Quantity. The squares of those sources' effects sum up to its diagonal. Between plausible assignments of
  /// flashes the numbers' covariance is not known, and left out.
  std::array<std::array<double, kQuantityCount>, kQuantityCount> own_covariance{};
};

/// "centres", "map error 3", "ball diameter" ...
std::string name_of(const BudgetSource& source);

/// Which sources to look at: those that shots share are few, and cost a tenth.
enum class SourceChoice { all, shared };

/// Of the readout that reduce() gives, with the images, effects and weights that it used. Fails as reduce()
/// does, and with the estimator "legacy", which states no sd. Allocates; some hundred fits, a millisecond or
/// two.
Result<Budget> uncertainty_budget(const Frame& frame, Estimator estimator = Estimator::best,
                                  const ReduceOptions& options = {}, SourceChoice choice = SourceChoice::all);

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
  /// Half a unit in the second significant digit of the stated standard uncertainty, or in the first where
  /// the draws are too few for two (JCGM 101, 7.9.2 and 8.1).
  double tolerance = 0.0;
  int digits = 2;
  double end_sd = 0.0;  ///< of low and high, from the number of draws; the larger
  Agreement agrees = Agreement::open;
};

/// All inputs are drawn from what is known of them, and the shot is fitted again, many times: says whether
/// the stated intervals, which rest on the law of propagation, are those of the draws.
/// Source: JCGM 101:2008 (GUM, supplement 1), 7 and 8.
struct MonteCarlo {
  int draws = 0;
  std::uint64_t seed = 0;
  std::array<std::optional<DrawnNumber>, kQuantityCount> quantities{};  ///< index: Quantity

  const std::optional<DrawnNumber>& of(Quantity q) const { return quantities[static_cast<std::size_t>(q)]; }
};

inline constexpr int kMinDraws = 1000;
inline constexpr int kMaxDraws = 10000000;

/// Noise that was stated is drawn from normal distributions, as are scale, map, ball and air; noise that was
/// estimated from Student's t, one factor for all that have the same estimate. Images, effects and weights
/// stay those of the shot. Held against expanded_uncertainty(). Fails as uncertainty_budget() does. `draws`:
/// kMinDraws to kMaxDraws, some 10 us each. The same from the same seed.
Result<MonteCarlo> monte_carlo(const Frame& frame, int draws, std::uint64_t seed,
                               Estimator estimator = Estimator::best, const ReduceOptions& options = {});

}  // namespace strobe::reduction
