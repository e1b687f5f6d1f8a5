// The contact ODE fitted to measured conditions by plain least squares, without priors: the normal spring and
// dashpot of each follow from its restitution and dwell time; five parameters are common to all: mu, k_t/k,
// c_t, the offset over the footprint's radius and the ball's alpha (bounded_least_squares.hpp). Kept beside
// fit() (model_fit.hpp) since the thesis's tables and the defaults of ContactCoefficients rest on it.
// Allocates; thread-safe; some 20 ms for 21 conditions.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/impact/fit/observation.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "common/result.hpp"

namespace strobe::impact {

/// Means of a condition with the sds of single shots; e from the means of vy, which carry more digits than
/// the table's e.
Observation observation_of(const thesis::Condition& condition);

enum ContactParameter : int { kFitMu, kFitStiffness, kFitDamping, kFitOffset, kFitAlpha, kFitParameters };

constexpr std::string_view name(ContactParameter parameter) {
  constexpr std::array<std::string_view, kFitParameters> names{"mu", "stiffness_ratio", "damping_ratio",
                                                               "offset_share", "alpha"};
  return names[static_cast<std::size_t>(parameter)];
}

using ContactVector = Eigen::Matrix<double, kFitParameters, 1>;
using ContactMatrix = Eigen::Matrix<double, kFitParameters, kFitParameters>;

struct ContactFitOptions {
  OffsetLaw law = OffsetLaw::against_spin;
  double offset_reference_mps = kContactOffsetReference_mps;
  double vx_sd_mps = 0.38;       ///< divisor of lift-off's residuals: the thesis's pooled replicate sd
  double omega_sd_radps = 11.5;  ///< the same for the spin
  double tolerance = 1e-9;       ///< of the contact, 1e-12…1e-6
  ContactMethod method = ContactMethod::collocation;

  ContactOptions contact() const { return {.method = method, .tolerance = tolerance}; }
};

struct ContactFitPoint {
  std::string name;
  ContactSummary computed;
  double stiffness_npm = 0.0;
  double damping_ratio = 0.0;    ///< of the normal spring
  double vx_residual_mps = 0.0;  ///< computed less measured
  double omega_residual_radps = 0.0;
};

struct ContactFit {
  ContactVector value;               ///< in the order of ContactParameter
  ContactMatrix covariance;          ///< scaled by chi_square/degrees_of_freedom
  ContactCoefficients coefficients;  ///< common to all conditions; e and dwell_s are those of the first
  double chi_square = 0.0;
  int degrees_of_freedom = 0;
  double vx_rms_mps = 0.0;
  double omega_rms_radps = 0.0;
  int iterations = 0;
  std::vector<ContactFitPoint> points;

  double sd(ContactParameter parameter) const;
};

/// Coefficients and ball of one observation under shared parameters.
ContactCoefficients coefficients_of(const Observation& observation, const ContactVector& parameters,
                                    const ContactFitOptions& options);
ball::Ball ball_of(const ContactVector& parameters);

/// Clamped to the bounds of a fit: mu 0…10, k_t/k 1e-2…1e2, c_t 0.01…10, offset 0…1, alpha 0.1…2/3.
ContactVector within_bounds(const ContactVector& parameters);

/// Fails with fewer than three observations, an observation that simulate() refuses (named), parameters that
/// the observations do not determine, or no convergence in 200 iterations.
Result<ContactFit> fit_contact(std::span<const Observation> observations,
                               const ContactFitOptions& options = {});

/// The fit without one group, and its prediction of that group (with the group's own e and dwell times).
struct ContactHeldOutGroup {
  std::string group;
  ContactVector value;
  double vx_rms_mps = 0.0;
  double omega_rms_radps = 0.0;
};

/// In order of the groups' names. Fails like fit_contact(), with the first error.
Result<std::vector<ContactHeldOutGroup>> leave_one_group_out(std::span<const Observation> observations,
                                                             const ContactFitOptions& options = {});

}  // namespace strobe::impact
