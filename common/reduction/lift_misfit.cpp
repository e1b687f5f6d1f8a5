#include "common/reduction/lift_misfit.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace strobe::reduction {

double mean_speed_mps(const Observations& all, std::size_t leg) {
  const Observation* first = nullptr;
  const Observation* last = nullptr;
  for (const Observation& o : all.images) {
    if (!o.use_centre || leg_index(*o.leg) != leg) continue;
    if (!first) first = &o;
    last = &o;
  }
  if (first == last) return 0.0;
  const Eigen::Vector2d way = last->centre_m - first->centre_m;
  return std::hypot(way.x(), way.y()) / (last->time_s - first->time_s);
}

double lift_per_s(const flight::Aerodynamics& air, double speed_mps, double omega_radps) {
  return speed_mps > 0.0 ? air.lift_mps2(speed_mps, omega_radps) / speed_mps : 0.0;
}

LiftMisfit::LiftMisfit(const ShotFit& fit) {
  if (!fit.effects.magnus || !fit.joint.air_used) return;
  AirErrors errors = fit.air_fit.prior;
  constexpr double kWide = 100.0;  // the images alone decide
  for (std::size_t leg = 0; leg < 2; ++leg) {
    speed_mps_[leg] = mean_speed_mps(fit.observations, leg);
    errors[kLiftError[leg]] = {0.0, kWide * fit.air.lift_per_m * speed_mps_[leg], true};
  }
  JointFit joint = fit.joint;
  const AirFit open = fit_air(fit.observations, fit.air, errors, fit.air_fit.value, joint);
  for (std::size_t leg = 0; leg < 2; ++leg) {
    const std::size_t p = kLiftError[leg];
    const double fitted =
        fit.spin[leg] ? lift_per_s(fit.air, speed_mps_[leg], fit.spin[leg]->omega_radps) : 0.0;
    seen_per_s_[static_cast<Eigen::Index>(leg)] = fitted + open.value[p];
    for (std::size_t other = 0; other < 2; ++other) {
      const std::size_t q = kLiftError[other];
      covariance_(static_cast<Eigen::Index>(leg), static_cast<Eigen::Index>(other)) =
          open.by_noise[p][q] + open.by_prior[p][q];
    }
  }
  air_ = fit.air;
  known_ = covariance_.trace() > 0.0;
}

double LiftMisfit::chi_squared(const std::array<std::optional<double>, 2>& omega_radps) const {
  if (!known_) return 0.0;
  Eigen::Vector2d lift = seen_per_s_;
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (omega_radps[leg])
      lift[static_cast<Eigen::Index>(leg)] = lift_per_s(air_, speed_mps_[leg], *omega_radps[leg]);
  }
  // The coefficient's error is the ball's: of both legs the same.
  const Eigen::Vector2d sd = air_.law.lift_share_sd * lift;
  const Eigen::Matrix2d covariance = covariance_ + sd * sd.transpose();
  const Eigen::Vector2d miss = seen_per_s_ - lift;
  const double chi_squared = miss.dot(covariance.ldlt().solve(miss));
  return std::isfinite(chi_squared) ? chi_squared : 0.0;
}

}  // namespace strobe::reduction
