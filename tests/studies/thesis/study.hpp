// The whole study: every way of predicting the 21 conditions, each spin predicted from the other two.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/studies/thesis/cells.hpp"
#include "tests/studies/thesis/shots.hpp"

namespace strobe::studies {

/// One condition with its prediction.
struct PredictedCondition {
  const thesis::Condition* condition = nullptr;
  impact::ContactObservation observation;
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
