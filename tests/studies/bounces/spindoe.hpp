// Bounces of table-tennis balls in flights of SpinDOE (T. Gossard, J. Tebbe, A. Ziegler, A. Zell, 2023): positions at
// some 140 Hz and one spin vector a flight. No licence is stated: predictions are judged by them, nothing is copied.
// Read from a folder with index.csv and the flights as NNN.csv (the dataset's trajectories.zip, unpacked).
//
// A flight is split where two quadratics in time, over at most 14 positions each, leave the least squares; they meet at
// the bounce. Axes: along the slip of the contact point at touchdown, s = v_t + omega × (-R·z), and up; friction acts
// along s alone, so that the bounce is a plane one. Spin before it is known, after it not.
// The stored y component of the spin has the opposite sign of a right-handed one: the flights that tell the friction,
// which are not judged, say so (the change of velocity lies along the slip).
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/bounces/prediction.hpp"

namespace strobe::studies {

struct TableTennisBounce {
  int flight = 0;
  double noise_m = 0.0;  ///< rms residual of both quadratics
  published::Bounce bounce{};
  /// Change of velocity across the slip over the normal impulse: 0 but for errors. With the stored y of the spin, too.
  double across = 0.0, across_as_stored = 0.0;
};

struct TableTennis {
  int flights = 0, without_bounce = 0;
  int implausible = 0;  ///< noise, restitution or spin beyond what such a bounce has
  int across = 0;       ///< velocity changed across the slip by more than a tenth of the impulse: no friction does that
  std::vector<TableTennisBounce> bounces;
};

/// Fails with the file that cannot be read.
Result<TableTennis> read_spindoe(const std::string& folder);

/// Friction from the flights of even number: the median impulse ratio of those with the longest slip, that cannot have
/// gripped (|s| above 1.5 of what any friction below .4 stops). The others, as cases to predict.
struct Judged {
  double mu = 0.0;
  int telling = 0;
  double across_rms = 0.0, across_as_stored_rms = 0.0;  ///< of the telling flights
  std::vector<bounces::Case> cases;
};
Judged judged_by(const TableTennis& flights);

}  // namespace strobe::studies
