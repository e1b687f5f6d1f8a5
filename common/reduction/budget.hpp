// The uncertainty budget of one shot: by how much each source moves each number, by the law of propagation. The numbers
// are computed again with each input moved a little either way, so that the budget does not rest on the covariance that
// the fit states: the squares of its lines sum up to sd and sd_systematic, or one of both is wrong.
// Thread-safe; deterministic; allocates; some hundred fits, a millisecond or two.
// Source: JCGM 100:2008 (GUM), 5.1 and F.1.2; the differences: its 5.1.3, note 2.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/reduction/reduce.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

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
  drag,           ///< tolerance of the drag coefficient
  lift_incoming,  ///< of the lift coefficient
  lift_rebound,   //
  spin_decay,     ///< of the spin's decay in flight
};
inline constexpr std::size_t kSourceCount = 14;

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
  /// Where its noise was estimated; absent: infinitely many. Sources with the same factor have the same estimate.
  std::optional<double> degrees_of_freedom{};
  int factor = -1;
  /// One standard deviation's, in the number's unit; index: Quantity; 0 where the number is absent. Of one input with the
  /// sign of a larger input; of many the root of the sum of squares.
  std::array<double, kQuantityCount> effect{};

  double of(Quantity q) const { return effect[static_cast<std::size_t>(q)]; }
};

struct Budget {
  std::vector<BudgetSource> sources;  ///< in the order of Source; those without any effect are left out

  /// All sources together.
  double combined_sd(Quantity q) const;
  /// Effective (Welch-Satterthwaite); absent: infinitely many.
  std::optional<double> degrees_of_freedom(Quantity q) const;
};

/// "centres", "map error 3", "ball diameter" ...
std::string name_of(const BudgetSource& source);

/// Which sources to look at: those that shots share are few, and cost a tenth.
enum class SourceChoice { all, shared };

/// Of the readout that reduce() gives, with the images, effects and weights that it used. Fails as reduce() does, and
/// with the estimator "legacy", which states no sd.
Result<Budget> uncertainty_budget(const Frame& frame, Estimator estimator = Estimator::best,
                                  const ReduceOptions& options = {}, SourceChoice choice = SourceChoice::all);

}  // namespace strobe::reduction
