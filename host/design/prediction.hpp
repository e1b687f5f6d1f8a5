// The uncertainty that a plan, a set-up and a number of balls will give, before anything is fired: the shots
// that are expected, reduced as if they had been photographed, with the budgets that the reduction states of
// them. Nothing here knows how an sd comes about but the reduction. Deterministic; thread-safe; allocates;
// some 50 us a ball, and 2 ms for each whose budget is made. Source: JCGM 100:2008 (GUM), 5; design by the
// bound: V. V. Fedorov, Theory of Optimal Experiments (1972).
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/reduction/readout.hpp"
#include "host/design/expected_ball.hpp"
#include "host/design/expected_shot.hpp"
#include "host/design/set_up.hpp"
#include "host/series/series.hpp"

namespace strobe::host {

/// Of one quantity, over the balls that can be read.
struct PredictedQuantity {
  double mean = 0.0;
  double spread = 0.0;             ///< standard deviation of the true numbers from ball to ball
  double shot_sd = 0.0;            ///< total standard uncertainty of one shot's number, rms over the balls
  double shared_sd = 0.0;          ///< what of it all shots of a series have in common
  std::vector<BudgetLine> budget;  ///< of shot_sd², the largest first; empty unless asked for

  /// Of single shots about their mean.
  double scatter_sd() const;
  /// Standard uncertainty of a series' mean, n >= 1 shots.
  double mean_sd(int n) const;
  /// Half width of the mean's 95 % interval, as `strobe series` will state it of n >= 2 shots.
  double expanded(int n) const;
};

/// Share of balls whose spins may be read as others.
inline constexpr double kMaxAliasedShare = 0.01;

struct Prediction {
  int balls = 0;                       ///< expected
  int readable = 0;                    ///< of them: shots that will count
  std::map<std::string, int> reasons;  ///< why others will not, and how many
  /// Of the readable ones whose spins are read as others that explain the equators as well, or are flagged
  /// so.
  int aliased = 0;
  std::array<int, 2> incoming{}, rebound{};  ///< images, fewest and most
  double largest_overlap = 0.0;
  int most_at_one_place = 0;  ///< images, as ExpectedShot has them
  std::array<std::optional<PredictedQuantity>, reduction::kQuantityCount> quantities{};  ///< index: Quantity

  /// Whether so few balls have their spin read wrongly that it and what follows from it can be relied upon.
  bool spins_known() const { return aliased <= kMaxAliasedShare * readable; }

  const std::optional<PredictedQuantity>& of(reduction::Quantity q) const {
    return quantities[static_cast<std::size_t>(q)];
  }
  double readable_share() const { return balls > 0 ? static_cast<double>(readable) / balls : 0.0; }
};

struct PredictionOptions {
  std::size_t balls = 64;
  std::size_t budgets = 8;  ///< balls of which a budget is made; 0: shared_sd is 0, too
  /// Find out which flash made which image, as of a photograph; else that is taken as known. Some 0.3 ms a
  /// ball.
  bool match = true;
};

/// Which balls can be read, with the right spin, and with which uncertainty, is tried with noise drawn for
/// each. Spins, and what follows from them, are absent where !spins_known(). Fails for a ball beyond the
/// models' ranges.
Result<Prediction> predict(const ExpectedBall& ball, const SetUp& set_up, const ExpectedTrain& train,
                           const PredictionOptions& options = {});

}  // namespace strobe::host
