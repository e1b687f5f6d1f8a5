// Predicted numbers against Tables 5 to 10, cell by cell: z = (predicted - published mean)/published sd.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/reduction/readout.hpp"
#include "tests/studies/thesis/prediction.hpp"

namespace strobe::studies {

struct Cell {
  std::string condition;
  reduction::Quantity quantity = reduction::Quantity::vx_lo_mps;
  double predicted = 0.0, published = 0.0, published_sd = 0.0;
  /// An input, or a value that follows from inputs alone (with measured e: vy at lift-off): its z does not
  /// rate the model.
  bool input = false;
  double z() const { return (predicted - published) / published_sd; }
};

/// The lift-off's velocities and spin, by which a prediction is rated.
bool is_lift_off_motion(reduction::Quantity quantity);

/// The quantities of an error-free readout.
reduction::Quantities quantities_of(const impact::Motion& touchdown, const impact::Motion& lift_off,
                                    double dwell_s, double dwell_distance_m);

/// One cell for each published number of the condition that is among the quantities.
std::vector<Cell> cells_of(const thesis::Condition& condition, const reduction::Quantities& predicted,
                           Vertical vertical);

struct Tally {
  int count = 0;
  double rms_z = 0.0, share_within_2 = 0.0;
  int beyond_3 = 0;
};

template <typename Wanted>
Tally tally(std::span<const Cell> cells, Wanted wanted) {
  Tally t;
  for (const Cell& cell : cells) {
    if (!wanted(cell)) continue;
    const double z = cell.z();
    ++t.count;
    t.rms_z += z * z;
    t.share_within_2 += z * z <= 4.0 ? 1.0 : 0.0;
    t.beyond_3 += z * z > 9.0 ? 1 : 0;
  }
  if (t.count == 0) return t;
  t.rms_z = std::sqrt(t.rms_z / t.count);
  t.share_within_2 /= t.count;
  return t;
}

// Whole simulated shots of a predicted condition: the rig throws, bounces by the prediction's contact,
// flashes and digitizes; the frames are reduced like any others. Deterministic from the seed; thread-safe;
// allocates.

struct ShotSeries {
  reduction::Quantities mean;  ///< of the readouts that have the number
  reduction::Quantities sd;    ///< population sd of them
  int shots = 0;
  int without_readout = 0;  ///< no ball, or a frame that cannot be reduced
};

/// As in the thesis: machine's spread and tablet's noise fitted to the condition, 3 ms between flashes;
/// reduced by the best estimator. One shot without spread and noise if `exact`. Fails for a condition that no
/// scene can be fitted to.
Result<ShotSeries> shoot_series(const thesis::Condition& condition, const Prediction& prediction, int shots,
                                std::uint64_t seed, bool exact);

// The whole study: every way of predicting the 21 conditions, each spin predicted from the other two.

/// One condition with its prediction.
struct PredictedCondition {
  const thesis::Condition* condition = nullptr;
  impact::Observation observation;
  const Constants* constants = nullptr;
  Prediction prediction;
  InputSpread spread;
};

/// The predictions by one combination of options.
struct Predictions {
  Dashpot dashpot = Dashpot::tied;
  Vertical vertical = Vertical::measured;
  std::vector<Constants> constants;            ///< one for each spin
  std::vector<PredictedCondition> conditions;  ///< in the tables' order
  std::vector<Cell> cells;
};

/// Fails as constants_without() and predict().
Result<Predictions> predict_all(const thesis::Data& data, Dashpot dashpot, Vertical vertical);

/// The rebound models of common/impact/fit in the same cross-validation: fitted to two spins, the third
/// predicted from its own e. vx and omega at lift-off only.
struct Algebraic {
  std::string model;
  std::vector<Cell> cells;
};
Result<std::vector<Algebraic>> algebraic_models(const thesis::Data& data);

/// Readouts of whole simulated shots of those predictions.
struct Shots {
  std::string name;
  std::vector<Cell> cells;
  int shots = 0, without_readout = 0;
};
Result<Shots> shoot_all(const Predictions& predictions, int shots, std::uint64_t seed, bool exact);

}  // namespace strobe::studies
