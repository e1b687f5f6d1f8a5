#include "common/reduction/time_response.hpp"

#include <algorithm>

#include "common/reduction/spin_line.hpp"

namespace strobe::reduction {
namespace {

using Response = decltype(Number::grad);

/// The two whitened measurements of an image's centre, and how they change with its time.
struct Moved {
  ImageRows rows;
  double by_time[2];

  /// J^T W v
  JointVector right(std::size_t leg) const {
    JointVector sum{};
    for (std::size_t k = 0; k < 2; ++k) {
      for (std::size_t i = 0; i < 4; ++i) sum[kLegStart[leg] + i] += rows.row[k][i] * by_time[k];
      sum[kTilt] += rows.row[k][4] * by_time[k];
      sum[kScale] += rows.row[k][5] * by_time[k];
    }
    return sum;
  }
};

Moved moved_by_time(const ShotFit& fit, const geometry::Rotation2d& tilt, const Observation& o) {
  const JointFit& joint = fit.joint;
  const std::size_t leg = leg_index(*o.leg);
  Moved moved{image_rows(fit.observations, joint, tilt, o), {}};
  const double t = moved.rows.time_s;
  const flight::Forcing& forcing = joint.forcing[leg];
  const Eigen::Vector2d gained = t * (forcing.acceleration_mps2 + 0.5 * t * forcing.jerk_mps3);
  const double* z = &joint.unknowns[kLegStart[leg]];
  const Eigen::Vector2d velocity =
      Eigen::Vector2d(z[2], z[3]) / joint.legs[leg].span_s + joint.unknowns[kScale] * (tilt * gained);
  moved.by_time[0] = -moved.rows.white[0] * velocity.x();
  moved.by_time[1] = -moved.rows.white[1] * velocity.x() - moved.rows.white[2] * velocity.y();
  return moved;
}

/// The air's errors follow what the paths do not take up of the images.
void add_air(const ShotFit& fit, const geometry::Rotation2d& tilt, std::size_t leg, const Moved& moved,
             const JointVector& right, Response& response) {
  const AirFit& air = fit.air_fit;
  std::array<double, kAirErrorCount> left{};
  for (std::size_t p = 0; p < kAirErrorCount; ++p) {
    const Eigen::Vector2d pull = fit.joint.unknowns[kScale] * (tilt * air.acceleration_mps2[p][leg]);
    const Eigen::Vector2d bent = moved.rows.moved_by(pull);
    left[p] = bent.x() * moved.by_time[0] + bent.y() * moved.by_time[1] + dot(air.response[p], right);
  }
  for (std::size_t p = 0; p < kAirErrorCount; ++p) {
    for (std::size_t q = 0; q < kAirErrorCount; ++q)
      response[kAir + p] += (air.by_noise[p][q] + air.by_prior[p][q]) * left[q];
  }
}

void add_spin(const ShotFit& fit, std::size_t leg, std::vector<Response>& all) {
  const auto& spin = fit.spin[leg];
  if (!spin) return;
  SpinLine line;
  for (const EquatorReading& r : fit.equators[leg]) line.add(r.time_s, 0.0, weight(r, spin->omega_radps));
  for (const EquatorReading& r : fit.equators[leg]) {
    const double lever = weight(r, spin->omega_radps) * (r.time_s - line.mean_x()) / line.moment();
    all[r.index][kSpin[leg]] = -lever * spin->omega_radps;
  }
}

}  // namespace

std::vector<Response> time_response(const ShotFit& fit) {
  std::vector<Response> all(fit.observations.images.size(), Response{});
  const geometry::Rotation2d tilt = tilt_of(fit.joint);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Observation& o = fit.observations.images[i];
    if (!o.use_centre || !fit.joint.legs[leg_index(*o.leg)].fitted) continue;
    const std::size_t leg = leg_index(*o.leg);
    const Moved moved = moved_by_time(fit, tilt, o);
    const JointVector right = moved.right(leg);
    const JointVector unknowns = fit.joint.factor.unknowns(fit.joint.factor.whitened(right));
    std::copy(unknowns.begin(), unknowns.end(), all[i].begin());
    add_air(fit, tilt, leg, moved, right, all[i]);
  }
  for (std::size_t leg = 0; leg < 2; ++leg) add_spin(fit, leg, all);
  return all;
}

}  // namespace strobe::reduction
