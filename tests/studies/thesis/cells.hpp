// Predicted numbers against Tables 5 to 10, cell by cell: z = (predicted - published mean)/published sd.
#pragma once

#include <cmath>
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

}  // namespace strobe::studies
