// What nobody knows exactly of the air's pull, fitted with the paths. Part of the reduction, not of its
// interface. Thread-safe; no allocation.
#pragma once

#include <array>

#include "common/reduction/joint_fit.hpp"

namespace strobe::reduction {

/// Parameters: the drag coefficient's error as a share of it, and for either leg what its lift is more than
/// the model's, as acceleration over speed. [1, 1/s, 1/s]
inline constexpr std::size_t kDragError = 0;
inline constexpr std::size_t kLiftError[2] = {1, 2};
inline constexpr std::size_t kAirErrorCount = 3;

struct AirError {
  double mean = 0.0;  ///< before the path is looked at
  double sd = 0.0;    ///< likewise; 0: exact, not fitted
  bool open = false;  ///< of a spin that is not known: counts as statistical
};
using AirErrors = std::array<AirError, kAirErrorCount>;

using AirCovariance = std::array<std::array<double, kAirErrorCount>, kAirErrorCount>;

using AirAccelerations = std::array<std::array<Eigen::Vector2d, 2>, kAirErrorCount>;

/// Eigen's vectors begin undefined, in arrays and with {}, too.
inline AirAccelerations no_air_accelerations() {
  AirAccelerations none;
  for (auto& legs : none) legs.fill(Eigen::Vector2d::Zero());
  return none;
}

struct AirFit {
  AirErrors prior;
  std::array<double, kAirErrorCount> value{};
  /// By the noise of the images, and by what is not known of the air before.
  AirCovariance by_noise{};
  AirCovariance by_prior{};
  /// How the joint fit's unknowns follow each error.
  std::array<JointVector, kAirErrorCount> response{};
  /// What it adds to either leg's acceleration; 0 unless it is fitted. [m/s^2]
  AirAccelerations acceleration_mps2 = no_air_accelerations();
};

/// `fitted_with`: the errors that the joint fit has taken into account already.
///
/// The errors' least squares estimates from the paths' curvature and from what was known before, and the
/// joint fit moved to them. The joint fit is linear in accelerations, so that one step is exact to the
/// product of small corrections. An error that the images cannot tell keeps its mean and its sd: it then
/// widens the numbers that hang on it. Source: least squares with prior information, e.g. Koch, Parameter
/// Estimation and Hypothesis Testing, 3.2.
AirFit fit_air(const Observations& all, const flight::Aerodynamics& air, const AirErrors& prior,
               const std::array<double, kAirErrorCount>& fitted_with, JointFit& joint);

}  // namespace strobe::reduction
