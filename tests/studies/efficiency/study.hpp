// How near estimators come to the best that any could do: simulated shots of the thesis's conditions,
// digitized with known noise, reduced, and held against the truth and the Cramer-Rao bound. Deterministic
// from the seed, whatever the number of threads. Thread-safe; allocates.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/simulated_shot.hpp"

namespace strobe::studies {

/// An estimator with its options.
struct Method {
  std::string name;
  reduction::Estimator estimator = reduction::Estimator::best;
  reduction::ReduceOptions options;
};

/// How the shots are photographed.
struct Scenario {
  std::string name;
  std::string what;  ///< in words
  int images = 5;    ///< of each leg
  bool noise_stated = true;
  double tilt_rad = 0.0;  ///< camera rolled uniformly within ± this
  double late_s = 0.0;    ///< lateness of the last flash before touchdown, as measured
};

/// best, the same without air, without air and gravity, two-point, legacy.
std::vector<Method> all_methods();
std::vector<Scenario> all_scenarios();

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Errors of one quantity by one method.
struct Score {
  int shots = 0;
  int absent = 0;         ///< of the shots: no number
  double rms = 0.0;       ///< of the error, in the quantity's unit
  double bias = 0.0;      ///< mean error, in units of the bound
  double by_bound = 0.0;  ///< rms of error/bound
  double typical = 0.0;   ///< median of |error|/bound over that of the normal distribution, 0.6745
  // Of the shots with a stated sd; NaN if there is none.
  double by_sd = kUnknown;      ///< rms of error/stated sd
  double within_68 = kUnknown;  ///< share of errors within the 68.27 % interval
  /// Within the expanded uncertainty.
  double within_95 = kUnknown;
};

using Scores = std::array<Score, reduction::kQuantityCount>;

struct Condition {
  std::string name;
  std::vector<Scores> of_method;  ///< in the order of the methods
};

struct Plan {
  int shots = 20000;  ///< of each condition; over 50 phases of the flash train against the impact
  std::uint64_t seed = 1;
  int threads = 2;
  std::vector<test::Bounce> bounces;
  std::vector<Method> methods;
};

/// All conditions of one scenario. `done` counts conditions, for a progress display.
std::vector<Condition> run(const Plan& plan, const Scenario& scenario, std::atomic<int>& done);

}  // namespace strobe::studies
