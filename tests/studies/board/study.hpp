// Is what is promised of the board's next photograph kept? Drawn cameras, lenses and boards; the photographs so
// far and the planned one are rendered, searched for the board and calibrated from. Deterministic from the seed,
// whatever the number of threads. Thread-safe; allocates.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

namespace strobe::studies {

struct BoardStudyPlan {
  int set_ups = 100;
  std::uint64_t seed = 1;
  int threads = 2;
};

/// What one more photograph was to give, and gave: the scale's sd as a share, rms over the photograph.
struct Promise {
  double predicted = 0.0;
  double stated = 0.0;  ///< by the calibration with it
  double error = 0.0;   ///< the scale against the truth, rms over the same places
};

struct BoardSetUp {
  int photographs = 1;  ///< so far
  double before = 0.0;  ///< the scale's sd so far
  Promise advised, random;
  std::string failure;  ///< a board was not found; empty: all was measured
};

/// `done` counts set-ups, for a progress display.
std::vector<BoardSetUp> run(const BoardStudyPlan& plan, std::atomic<int>& done);

}  // namespace strobe::studies
