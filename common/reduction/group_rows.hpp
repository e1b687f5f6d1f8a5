// The measurements whose noise was estimated from the shot, as rows of the fit: what of a number's variance
// each of them makes. Pure; thread-safe; allocates.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// A whitened measurement of estimated noise, with its non-zero columns.
struct GroupRow {
  NoiseGroup noise = NoiseGroup::stated;
  std::size_t leg = 0;
  std::array<double, 4> own{};
  double tilt = 0.0, height = 0.0, scale = 0.0;

  double operator*(const JointVector& u) const {
    const double* z = &u[kLegStart[leg]];
    return own[0] * z[0] + own[1] * z[1] + own[2] * z[2] + own[3] * z[3] + tilt * u[kTilt] +
           height * u[kHeight] + scale * u[kScale];
  }
};

std::vector<GroupRow> group_rows(const ShotFit& fit);

}  // namespace strobe::reduction
