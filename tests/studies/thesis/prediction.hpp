// Predicts a condition of the thesis by the contact ODE with constants from the other two spins alone.
// Nothing of the predicted spin is used: neither for the five constants, nor the offset's reference speed,
// nor (optionally) its restitution and dwell time. Pure; deterministic; thread-safe; allocates.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "common/data/thesis_data.hpp"
#include "common/impact/fit/contact_fit.hpp"
#include "common/result.hpp"

namespace strobe::studies {

/// Where a condition's restitution and dwell time come from.
enum class Vertical {
  measured,  ///< the condition's own: vy at lift-off, e and the dwell time are inputs
  /// From the other two spins. e linear in |vy_TD|: what a shell loses by buckling and in its rubber grows
  /// with its speed (LaMarche, Cross: a straight line between 3 and 20 m/s). Dwell time a power of |vy_TD|: a
  /// spring N ~ y^n gives |vy|^((1 - n)/(1 + n)).
  by_speed,
  /// e besides linear in s/|vy_TD|, the slope of the contact point's path: friction presses the ball into the
  /// surface along that path, and takes of the rebound what it turns aside.
  by_speed_and_slip,
};
inline constexpr std::array<std::string_view, 3> kVerticalNames{"measured", "by-speed", "by-speed-and-slip"};

/// Whether the tangential dashpot is fitted.
enum class Dashpot {
  fitted,  ///< c_t with the others: five constants
  /// Its damping ratio c_t/(2·sqrt(k_t·m_t)), m_t = m·alpha/(1 + alpha), is held at 1/2, where dashpot and
  /// spring are equally strong at the tangential oscillation's own frequency: four constants. Two spins
  /// hardly separate c_t from k_t.
  tied,
};
inline constexpr std::array<std::string_view, 2> kDashpotNames{"fitted", "tied"};
inline constexpr double kTiedDamping = 0.5;

/// Constants from two spins.
struct Constants {
  std::string left_out;  ///< the spin not used
  impact::ContactVector value;
  double offset_reference_mps = 0.0;
  double chi_square = 0.0;           ///< of the fit, with residuals over .38 m/s and 11.5 rad/s
  std::array<double, 3> e_by{};      ///< constant, per m/s of |vy_TD|, per s/|vy_TD|
  std::array<double, 2> dwell_by{};  ///< ln of s at 1 m/s, exponent
};

/// The prediction of one condition.
struct Prediction {
  impact::Observation inputs;  ///< as measured, but for e and dwell time
  impact::ContactCoefficients coefficients;
  ball::Ball ball;
  impact::ContactSummary contact;
};

/// Without the observations of that spin. Fails as impact::fit_contact().
Result<Constants> constants_without(std::string_view spin, std::span<const impact::Observation> observations,
                                    Vertical vertical, Dashpot dashpot);

/// Fails on inputs that impact::simulate() refuses.
Result<Prediction> predict(const impact::Observation& observation, const Constants& constants,
                           Vertical vertical);

/// Sd of the predicted vx and omega at lift-off from the published sds of the inputs: the touchdown's
/// velocities and spin, and where they are measured e (by vy at lift-off) and the dwell time.
struct InputSpread {
  double vx_mps = 0.0, omega_radps = 0.0;
};
InputSpread input_spread(const impact::Observation& observation, const Constants& constants,
                         Vertical vertical);

}  // namespace strobe::studies
