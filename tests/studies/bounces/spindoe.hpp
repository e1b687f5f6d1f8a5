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
#include "common/impact/spatial/spatial_rebound.hpp"
#include "host/bounces/prediction.hpp"

namespace strobe::studies {

struct TableTennisBounce {
  int flight = 0;
  double noise_m = 0.0;  ///< rms residual of both quadratics
  published::Bounce bounce{};
  /// Change of velocity across the slip over the normal impulse: 0 but for errors. With the stored y of the spin, too.
  double across = 0.0, across_as_stored = 0.0;
};

/// The same bounce in space: x along the way before it, y up.
struct SpatialBounce {
  int flight = 0;
  bool across = false;  ///< counted as such
  impact::SpatialMotion touchdown;
  Eigen::Vector3d lift_off_mps;
  double sd_mps = 0.0;  ///< of a velocity after less what before it and the spin make of it
};

struct TableTennis {
  int flights = 0, without_bounce = 0;
  int implausible = 0;  ///< noise, restitution or spin beyond what such a bounce has
  int across = 0;       ///< velocity changed across the slip by more than a tenth of the impulse: no friction does that
  std::vector<TableTennisBounce> bounces;
  std::vector<SpatialBounce> in_space;  ///< all plausible ones
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

/// What a model, in space or given the motion in the plane of travel alone, says of the velocity along the surface. Its
/// coefficients are fitted (least sum of distances, on a grid) to the flights of even number for those of odd number, and the
/// other way. `within`: share of components within 1.96 sd, the measurement's and the scatter of the fitted half together.
struct SpatialTally {
  std::string model;
  bool in_space = true;
  int count = 0;
  double vx_rms_mps = 0.0, vz_rms_mps = 0.0, median_mps = 0.0, within = 0.0;
  Eigen::Vector2d even = Eigen::Vector2d::Zero(), odd = even;  ///< mu and e_x or k_t/k, fitted to those flights
};
std::vector<SpatialTally> judged_in_space(const std::vector<SpatialBounce>& bounces, bool with_across);

}  // namespace strobe::studies
