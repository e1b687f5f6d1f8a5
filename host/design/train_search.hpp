// The flash train that makes the wanted numbers most certain, within what lamps, shutter and digitizer allow.
// Deterministic; thread-safe; allocates; seconds.
//
// Without a limit to the number of images more are better, until they hide each other or lamps recharge: a
// search over periods, each coded as `strobe fire` codes it. With such a limit (a person who measures them,
// light of the room that adds up) images at both ends of a leg tell its slope better than images spread over
// it, by the root of 3 (N - 1) / (N + 1) in a straight leg: a search by exchange, one flash moved, added or
// left out at a time. Source: V. V. Fedorov, Theory of Optimal Experiments (1972), 3; R. K. Meyer and C. J.
// Nachtsheim, The coordinate-exchange algorithm, Technometrics 37 (1995).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/reduction/readout.hpp"
#include "common/result.hpp"
#include "host/config/rig_file.hpp"
#include "host/design/expected_ball.hpp"
#include "host/design/prediction.hpp"
#include "host/design/set_up.hpp"

namespace strobe::host {

struct TrainWish {
  std::vector<reduction::Quantity>
      quantities;       ///< whose sds count, all alike in their logarithm; never empty
  int most_images = 0;  ///< of a leg; 0: no limit
};

struct FoundTrain {
  PlanFile plan;          ///< as it would be fired, with its intervals
  Prediction prediction;  ///< of it
  std::string remark;     ///< why it is the given one; empty: it is another
  /// Geometric mean over what was wished of the given train's shot_sd over its own, scale and ball taken as
  /// exact: what flashes can do.
  double gain = 1.0;
  int tried = 0;  ///< trains
};

/// The best that was found; the plan as it is where none is better. `progress`: share done, 0 to 1; false
/// ends the search with the best so far. Fails as predict() does.
Result<FoundTrain> best_train(const ExpectedBall& ball, const SetUp& set_up, const RigFile& rig,
                              const PlanFile& plan, const TrainWish& wish,
                              const std::function<bool(double)>& progress = {});

/// Geometric mean over the quantities of the first's shot_sd over the second's: above 1 the second is better.
/// Quantities that either lacks are left out.
double gain(const Prediction& one, const Prediction& other,
            const std::vector<reduction::Quantity>& quantities);

}  // namespace strobe::host
