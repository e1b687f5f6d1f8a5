// Derives the scene of one of the thesis's conditions from its tables: means that a shot without spread
// reproduces, and spreads that together with the tablet's noise give the published standard deviations, so
// that nothing is counted twice. Pure; thread-safe; allocates.
//
// Ball: alpha of the contact mechanics' fit to all conditions (impact::kContactAlpha).
//
// Means: touchdown as printed. e and the dwell time such that vy_LO and the time from touchdown to lift-off
// come out as printed; the ball's weight in contact makes both differ from the coefficients by some tenths of
// a percent. mu, k_t/k, c_t and the offset's share delta minimize
//   (Δvx/(.01·sd vx))² + (Δomega/(.01·sd omega))² + sum of (ln(p/p_all)/w_p)²,
// Δ being simulated less published at lift-off, p_all the values fitted to all conditions (contact_ode.hpp)
// and w_p how far a condition is taken to be from them: .1 for mu, .5 for the others; none is moved by more
// than 2.5 w_p. So two numbers are met by those of four that need least of a change: mu and delta where the
// ball slides throughout, k_t/k, c_t and delta where it grips. What cannot be met is said in the file.
//
// Tablet: two-point velocities over T = 3 ms from centres with noise c carry sqrt(2)·c/T in every direction,
// along the flight besides v times the relative noise of the mean diameter, across it v times the noise of
// the surface line's angle; spins sqrt(2)·q/T from equators with noise q. c is the largest (at most 0.5 mm)
// for which none of these exceeds 90 % of the published sd it is part of; likewise q (at most 1 degree).
//
// Machine: sd² - noise², cut off at 0, in speed, angle and spin.
//
// Bounce, with secants from one sd below a mean to one above for derivatives: e_sd takes what noise and
// machine leave of the variance of vy_LO. What they and e_sd leave of those of vx_LO and omega_LO is made by
// two spreads, fully correlated or anti-correlated: of mu or k_t/k (whichever does it better), and of delta.
// They are those with the least relative misfit of the two sds, and of such the smallest; at most .25 of mu
// and .3 of k_t/k and of delta, since none may come out negative.
//
// Dwell time: sd² less the noise of two straight paths' ends, cut off at 0.
#pragma once

#include <string>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "common/reduction/readout.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// Standard deviations of two-point values from the tablet alone.
struct TwoPointNoise {
  double along_mps = 0.0;   ///< of the speed
  double across_rad = 0.0;  ///< of the path's angle
  double spin_radps = 0.0;
};

/// For a leg with that velocity, `diameters` measured diameters, and the scene's tablet.
TwoPointNoise two_point_noise(const Scene& scene, double vx_mps, double vy_mps, double diameters);

/// A quantity whose published spread is not met: less than what tablet and machine make of it, or more than
/// the contact's spread may add.
struct MissedSpread {
  reduction::Quantity quantity = reduction::Quantity::vx_lo_mps;
  double published_sd = 0.0;
  double expected_sd = 0.0;  ///< to first order
};

struct FittedScene {
  Scene scene;
  bool slides = false;       ///< throughout
  double left_vx_mps = 0.0;  ///< lift-off of a ball without spread, less the published mean
  double left_omega_radps = 0.0;
  std::vector<MissedSpread> missed;  ///< by more than 1 %
};

/// Fails if the condition is outside the impact models' ranges.
Result<FittedScene> fit_scene(const thesis::Condition& condition);

/// The scene file's text; keys with their default value are left out.
std::string to_toml(const FittedScene& fitted, const thesis::Condition& condition);

}  // namespace strobe::sim
