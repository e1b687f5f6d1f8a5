#include "common/reduction/air_fit.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace strobe::reduction {
namespace {

using AirMatrix = Eigen::Matrix<double, kAirErrorCount, kAirErrorCount>;
using AirVector = Eigen::Matrix<double, kAirErrorCount, 1>;

/// Chance passes it once in 16,000.
constexpr double kFarthest_sd = 4.0;

constexpr auto index(std::size_t i) { return static_cast<Eigen::Index>(i); }

void set_accelerations(const flight::Aerodynamics& air, const JointFit& joint, AirFit& fit) {
  for (auto& of_error : fit.acceleration_mps2) of_error.fill(Eigen::Vector2d::Zero());
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (!joint.legs[leg].fitted) continue;
    const Eigen::Vector2d v = leg_velocity_mps(joint, leg);
    const double speed = std::hypot(v.x(), v.y());
    fit.acceleration_mps2[kDragError][leg] = -air.drag_per_m * speed * v;
    fit.acceleration_mps2[kLiftError[leg]][leg] = {-v.y(), v.x()};
  }
}

/// Beyond these no air pulls a ball, and squares and quotients of what a frame may state overflow.
bool is_fitted(const AirError& error) {
  return std::isgreater(error.sd, 1e-12) && std::isless(error.sd, 1e12);
}

/// Of the whitened images: by each error, and with the joint fit's unknowns.
struct Normal {
  std::array<JointVector, kAirErrorCount> with_unknowns{};
  AirMatrix errors = AirMatrix::Zero();
  AirVector right = AirVector::Zero();
};

Normal normal_equations(const Observations& all, const JointFit& joint, const AirFit& fit) {
  const geometry::Rotation2d tilt = tilt_of(joint);
  std::array<std::array<Eigen::Vector2d, 2>, 2> pull;  // of each leg: drag's error, lift's
  for (std::size_t leg = 0; leg < 2; ++leg) {
    pull[leg][0] = joint.unknowns[kScale] * (tilt * fit.acceleration_mps2[kDragError][leg]);
    pull[leg][1] = joint.unknowns[kScale] * (tilt * fit.acceleration_mps2[kLiftError[leg]][leg]);
  }
  Normal n;
  for (const Observation& o : all.images) {
    if (!o.use_centre || !joint.legs[leg_index(*o.leg)].fitted) continue;
    const std::size_t leg = leg_index(*o.leg);
    const ImageRows rows = image_rows(all, joint, tilt, o);
    const std::array<std::size_t, 2> errors{kDragError, kLiftError[leg]};
    const std::array<Eigen::Vector2d, 2> moved{rows.moved_by(pull[leg][0]), rows.moved_by(pull[leg][1])};
    for (std::size_t e = 0; e < 2; ++e) {
      rows.add_gradient(leg, moved[e], n.with_unknowns[errors[e]]);
      for (std::size_t k = 0; k < 2; ++k) n.right[index(errors[e])] += moved[e][index(k)] * rows.residual[k];
      for (std::size_t f = 0; f <= e; ++f)
        n.errors(index(errors[e]), index(errors[f])) += moved[e].dot(moved[f]);
    }
  }
  return n;
}

/// What remains of the images' information once the path is fitted is between none and all of it, unless the
/// path itself is lost in rounding.
bool lost_in_rounding(const AirMatrix& remaining, const AirMatrix& all) {
  constexpr double kRounding = 1e-6;
  return !(remaining.diagonal().array() >= -kRounding * all.diagonal().array()).all();
}

/// Of errors that a tolerance and images tell together.
struct Combined {
  AirMatrix covariance, by_noise, by_prior;  ///< the covariance is the sum of the others
};

/// In units of the tolerances, along the axes of the images' information: no inverse there is, however much
/// or little the images tell, and each part is a covariance to the last bit.
Combined combine(const AirVector& sd, const AirMatrix& by_images) {
  const AirMatrix scaled = sd.asDiagonal() * by_images * sd.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<AirMatrix> axes(scaled);
  const AirMatrix v = sd.asDiagonal() * axes.eigenvectors();
  const Eigen::Array<double, kAirErrorCount, 1> told =
      axes.eigenvalues().array().max(0.0);  // but for rounding
  const auto along = [&](const auto& variance) -> AirMatrix {
    return v * variance.matrix().asDiagonal() * v.transpose();
  };
  const Eigen::Array<double, kAirErrorCount, 1> share = 1.0 / (1.0 + told);
  return {along(share), along(share * (told * share)), along(share * share)};
}

}  // namespace

AirFit fit_air(const Observations& all, const flight::Aerodynamics& air, const AirErrors& prior,
               const std::array<double, kAirErrorCount>& fitted_with, JointFit& joint) {
  AirFit fit;
  fit.prior = prior;
  const bool any = std::ranges::any_of(prior, is_fitted);
  if (!any || joint.degenerate() || !joint.air_used) return fit;
  set_accelerations(air, joint, fit);
  const Normal n = normal_equations(all, joint, fit);
  std::array<JointVector, kAirErrorCount> whitened;
  for (std::size_t p = 0; p < kAirErrorCount; ++p) whitened[p] = joint.factor.whitened(n.with_unknowns[p]);
  AirMatrix by_images = AirMatrix::Zero();
  AirVector sd = AirVector::Zero();
  AirVector right = AirVector::Zero();
  for (std::size_t p = 0; p < kAirErrorCount; ++p) {
    if (!is_fitted(prior[p])) continue;
    sd[index(p)] = prior[p].sd;
    right[index(p)] = n.right[index(p)] + (prior[p].mean - fitted_with[p]) / (prior[p].sd * prior[p].sd);
    for (std::size_t q = 0; q <= p; ++q) {
      if (!is_fitted(prior[q])) continue;
      by_images(index(p), index(q)) = by_images(index(q), index(p)) =
          n.errors(index(p), index(q)) - dot(whitened[p], whitened[q]);
    }
  }
  if (lost_in_rounding(by_images, n.errors)) return fit;
  const Combined told = combine(sd, by_images);
  AirVector more = told.covariance * right;
  if (!told.covariance.allFinite() || !more.allFinite()) return fit;
  for (std::size_t p = 0; p < kAirErrorCount; ++p) {
    if (!is_fitted(prior[p])) continue;
    // Images that ask for more are wrong themselves: their residuals must show it.
    const double reach = kFarthest_sd * prior[p].sd;
    fit.value[p] = std::clamp(fitted_with[p] + more[index(p)], prior[p].mean - reach, prior[p].mean + reach);
    more[index(p)] = fit.value[p] - fitted_with[p];
    for (std::size_t q = 0; q < kAirErrorCount; ++q) {
      if (!is_fitted(prior[q])) continue;
      fit.by_noise[p][q] = told.by_noise(index(p), index(q));
      fit.by_prior[p][q] = told.by_prior(index(p), index(q));
    }
    fit.response[p] = joint.factor.unknowns(whitened[p]);
    for (double& x : fit.response[p]) x = -x;
    for (std::size_t i = 0; i < kJointCount; ++i) joint.unknowns[i] += more[index(p)] * fit.response[p][i];
    for (std::size_t leg = 0; leg < 2; ++leg)
      joint.forcing[leg].acceleration_mps2 += more[index(p)] * fit.acceleration_mps2[p][leg];
  }
  return fit;
}

}  // namespace strobe::reduction
