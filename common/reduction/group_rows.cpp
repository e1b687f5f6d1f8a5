#include "common/reduction/group_rows.hpp"

namespace strobe::reduction {

std::vector<GroupRow> group_rows(const ShotFit& fit) {
  const Observations& all = fit.observations;
  const geometry::Rotation2d tilt = tilt_of(fit.joint);
  std::vector<GroupRow> rows;
  for (const Observation& o : all.images) {
    const bool centre = o.use_centre && o.centre_noise != NoiseGroup::stated;
    if (centre && fit.joint.legs[leg_index(*o.leg)].fitted) {
      for (const auto& r : image_rows(all, fit.joint, tilt, o).row) {
        rows.push_back({o.centre_noise, leg_index(*o.leg), {r[0], r[1], r[2], r[3]}, r[4], 0.0, r[5]});
      }
    }
    if (o.use_diameter && o.diameter_noise != NoiseGroup::stated) {
      rows.push_back({o.diameter_noise, 0, {}, 0.0, 0.0, all.ball_diameter_m / all.diameter_sd(o)});
    }
  }
  if (all.surface_noise == NoiseGroup::stated) return rows;
  const double weight = 1.0 / all.surface_sd();
  for (const Eigen::Vector2d& p : all.surface_m) {
    rows.push_back({all.surface_noise, 0, {}, weight * surface_lever_m(fit.joint, p), weight, 0.0});
  }
  return rows;
}

}  // namespace strobe::reduction
