// The whole study: every way of foretelling the 21 conditions, three times two spins telling the third.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/studies/thesis/cells.hpp"
#include "tests/studies/thesis/shots.hpp"

namespace strobe::studies {

/// How one condition was told.
struct Told {
  const thesis::Condition* condition = nullptr;
  impact::ContactObservation observation;
  const Constants* constants = nullptr;
  Forecast forecast;
  InputSpread spread;
};

/// One way of foretelling.
struct Forecasts {
  Dashpot dashpot = Dashpot::tied;
  Vertical vertical = Vertical::measured;
  std::vector<Constants> constants;  ///< one for each spin
  std::vector<Told> told;            ///< in the tables' order
  std::vector<Cell> cells;
};

/// Fails as constants_without() and foretell().
Result<Forecasts> foretell_all(const thesis::Data& data, Dashpot dashpot, Vertical vertical);

/// The algebraic in/out models of common/impact/fit under the same rule: fitted to two spins, the third
/// foretold from its own e. vx and omega at lift-off only: they know no contact.
struct Algebraic {
  std::string model;
  std::vector<Cell> cells;
};
Result<std::vector<Algebraic>> algebraic_models(const thesis::Data& data);

/// Readouts of whole simulated shots of those forecasts.
struct Shots {
  std::string name;
  std::vector<Cell> cells;
  int shots = 0;
  int without_readout = 0;
};
Result<Shots> shoot_all(const Forecasts& forecasts, int shots, std::uint64_t seed, bool exact);

}  // namespace strobe::studies
