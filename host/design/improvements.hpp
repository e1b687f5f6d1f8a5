// What would help most: the same shots predicted again with one thing better, in order of what it does for
// the wanted numbers. Deterministic; thread-safe; allocates; some milliseconds for each thing.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/reduction/readout.hpp"
#include "common/result.hpp"
#include "host/config/rig_file.hpp"
#include "host/design/expected_ball.hpp"
#include "host/design/prediction.hpp"
#include "host/design/set_up.hpp"

namespace strobe::host {

/// All that decides how certain a series will be.
struct Design {
  ExpectedBall ball;
  SetUp set_up;
  PlanFile plan;  ///< with its intervals
  int shots = 9;  ///< of a series, 2 or more
};

Result<Prediction> predict(const Design& design, const PredictionOptions& options = {});

struct Improvement {
  std::string what;  ///< "a lens 1.5 times as long: 6000 px/m, 0.48 m are seen"
  std::vector<double>
      expanded;       ///< of each quantity's mean, as PredictedQuantity::expanded(); NaN: cannot be read
  double gain = 1.0;  ///< geometric mean of expanded as it is over expanded so; above 1 it helps
};

/// One thing after the other, the most helpful first; those that help by less than a hundredth are left out.
/// `best`: the plan that best_train() found, if it was asked for. Fails as predict() does.
Result<std::vector<Improvement>> improvements(const Design& design, const RigFile& rig,
                                              std::span<const reduction::Quantity> quantities,
                                              const std::optional<PlanFile>& best = {});

}  // namespace strobe::host
