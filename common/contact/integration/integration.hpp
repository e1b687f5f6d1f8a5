// What the integration approach says about the images in contact: any motion through the contact (the pulse,
// the contact ODE, a fitted curve) scored against a set, the largest force, deformation and friction with
// their times, the contact's stiffness by several readings, and the measured drop of the ball's top beside
// the pulse's depth. SI units; pure; thread-safe; what returns a Result allocates.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/contact/integration/spin_pulse.hpp"
#include "common/contact/integration/value_sd.hpp"
#include "common/data/contact_set.hpp"

namespace strobe::contact {

// --- Scoring -------------------------------------------------------------------------------------------

struct TrajectoryPoint {
  double x_m = 0.0;           ///< travelled since touchdown
  double y_m = 0.0;           ///< less the height at touchdown: <= 0
  double rotation_rad = 0.0;  ///< since touchdown
};

/// A motion as a function of the time fraction; called for 0…1 and for images slightly outside of it.
using Trajectory = std::function<TrajectoryPoint(double time_fraction)>;

/// Turns fractions into metres and radians.
struct SetScale {
  double dwell_distance_m = 0.0;  ///< > 0, along the surface
  double diameter_m = ball::kThesisDiameter_m;
  /// Measured rotation from touchdown to lift-off, if known. The thesis prints fractions of it only; see
  /// end_spin_total().
  std::optional<double> total_rotation_rad;
};

/// Rotation error for one choice of the total rotation that the fractions are shares of.
struct RotationError {
  double total_rad = 0.0;
  double see_rad = 0.0;
  std::optional<double> see_fraction;  ///< see_rad over |total_rad|; absent for a total of 0
};

struct RotationScore {
  /// The total is the trajectory's own: this compares shapes. It flatters where that total is near zero
  /// (backspin): measured angles shrink with it. Judge those by the others.
  RotationError own_total;
  /// The total that fits best, sum(q·phi)/sum(q²) over interior images; N - 1 is then the degrees of freedom.
  RotationError fitted_total;
  double fitted_total_sd_rad = 0.0;
  /// Share of the trajectory's rotation (about the touchdown's angle) that the fractions follow, 0…1.
  double r_squared = 0.0;
  std::optional<RotationError> given_total;  ///< with SetScale::total_rotation_rad
  int n = 0;                                 ///< interior images with a rotation
};

/// sqrt(sum of squared differences/(N - 1)) over the interior images.
struct Score {
  double see_x_m = 0.0;
  double see_y_m = 0.0;
  int n = 0;
  std::optional<RotationScore> rotation;  ///< absent with fewer than two rotations, or all of them zero
};

/// Fails when fewer than two images lie between the end points, on a scale out of range, and on a trajectory
/// that is not finite at an image.
Result<Score> score(const ContactSet& set, const Trajectory& trajectory, const SetScale& scale);

Trajectory trajectory_of(const SpinPulse& pulse);
Trajectory trajectory_of(const impact::SinePulse& pulse);  ///< friction throughout, no rotation (thesis)

/// The total rotation that the fractions and the measured spins ask for, without any mechanics: the S for
/// which S·q(T) fits best a cubic with S·q'(0) = omega_TD·dwell, S·q'(1) = omega_LO·dwell, q(0) = 0, q(1)
/// = 1. Noise of the fractions pulls it a little towards zero. `sd_rad` from the residuals alone.
struct EndSpinTotal {
  double total_rad = 0.0;
  double sd_rad = 0.0;
  double residual_rad = 0.0;  ///< rms about that cubic
  int n = 0;
};
Result<EndSpinTotal> end_spin_total(const ContactSet& set, double omega_td_radps, double omega_lo_radps,
                                    double dwell_s);

// --- Largest values (the thesis's Table 16) --------------------------------------------------------------

/// One largest value and when it occurs.
struct Peak {
  ValueSd size;
  ValueSd time_s;
  ValueSd fraction;
};

struct Peaks {
  Peak normal_force;    ///< N
  Peak deformation;     ///< m, of the centre towards the surface
  Peak friction_force;  ///< N, magnitude; before the grip. The thesis has mu·(largest normal force).
  ValueSd total_rotation_rad;
  std::optional<ValueSd> grip_fraction;  ///< skid-to-grip; absent if the mean inputs slide throughout
  std::optional<ValueSd> grip_time_s;
};

/// Standard deviations of the pulse's inputs, taken as independent of each other: >= 0.
struct SpinPulseSd {
  double vx_mps = 0.0, vy_mps = 0.0, omega_radps = 0.0;
  double e = 0.0, mu = 0.0, dwell_s = 0.0;
  double diameter_m = 0.0, mass_kg = 0.0, alpha = 0.0, offset_m = 0.0;
};

/// The peaks with sd by the delta method: difference quotients over a hundredth of each sd either way, one
/// way where an input would leave its range (e above 1). A grip fraction's sd holds while the grip stays
/// within the contact; near its end the distribution is skewed.
tl::expected<Peaks, impact::InputError> peaks(const SpinPulseInput& input, const SpinPulseSd& sd);

// --- Stiffness -------------------------------------------------------------------------------------------

/// Readings of "the" stiffness of the contact, in N/m where nothing else is said. They differ since a damped
/// pulse is no linear spring.
struct Stiffness {
  double half_period = 0.0;  ///< m(pi/dwell)²: the whole contact is half a period of an undamped spring
  double secant = 0.0;       ///< largest force over largest deformation of the pulse
  double energy = 0.0;       ///< m·vy²/depth²: all of the energy stored at the deepest point
  /// Spring of the damped oscillator whose (e, dwell) these are, released at N = 0.
  double kelvin_voigt = 0.0;
  double kelvin_voigt_zeta = 0.0;
  double kelvin_voigt_damping = 0.0;  ///< c, N·s/m
  double compression = 0.0;  ///< m(pi/(2·t_depth))²: the time to the deepest point is a quarter period
  double peak_time = 0.0;    ///< m(pi/(2·t_peak))²: the time to the largest force is a quarter period
};

/// Errors as SpinPulse::make(). Kelvin–Voigt (impact/ode/normal_spring.hpp) needs e >= 0.001: 0 below.
tl::expected<Stiffness, impact::InputError> stiffness(const SpinPulseInput& input);

/// A stiffness printed elsewhere for a condition, to be explained.
struct PublishedStiffness {
  SpinPulseInput input;  ///< the condition's means
  double vy_lo_mps = 0.0;
  double stiffness = 0.0;        ///< N/m
  double measured_drop_m = 0.0;  ///< largest drop of the top among the images
};

/// One guess at how published stiffnesses came about: what it gives for each condition, and published over
/// that. A guess explains the numbers if the ratios are 1 within rounding; it is proportional to them if they
/// are equal to each other (`spread`, the sd of their logarithms, no more than rounding's).
struct StiffnessHypothesis {
  std::string_view name;
  std::vector<double> predicted;  ///< N/m
  std::vector<double> ratio;      ///< published over predicted
  double common_ratio = 0.0;      ///< geometric mean of them
  double spread = 0.0;
};

/// All readings of Stiffness; Hertz's and stiffer contacts (F ~ depth^n, n = 1.5, 2.6) of the same dwell
/// time; the pulse's largest force over the measured drop; and the largest force of an undamped half wave of
/// the measured impulse, pi·m·(vy_LO - vy_TD)/(2·dwell), over one depth for all conditions (fixed_depth_m()).
/// Needs at least two conditions; errors as stiffness().
tl::expected<std::vector<StiffnessHypothesis>, impact::InputError> explain_stiffness(
    std::span<const PublishedStiffness> published);

/// The depth that turns the half wave's largest force into the published stiffness, for each condition.
std::vector<double> fixed_depth_m(std::span<const PublishedStiffness> published);

// --- Depth -----------------------------------------------------------------------------------------------

/// How far the top of the ball goes down, over the pulse's centre: the factor that fits the interior images
/// best, sum(y·Y)/sum(Y²). sd: of the images (residuals); sd_inputs: of the pulse (the sds given) and of the
/// diameter.
struct DropRatio {
  double ratio = 0.0;
  double sd_images = 0.0;
  double sd_inputs = 0.0;
  double see_m = 0.0;    ///< about the scaled pulse, N - 1 degrees of freedom
  double depth_m = 0.0;  ///< ratio · the pulse's depth: the measured deformation of the top
  int n = 0;
};
Result<DropRatio> drop_ratio(const ContactSet& set, const SpinPulseInput& input, const SpinPulseSd& sd);

}  // namespace strobe::contact
