// Derives the scene of one of the thesis's conditions from its tables: means that a shot without spread
// reproduces, and spreads that together with the tablet's noise give the published standard deviations, so
// that nothing is counted twice. Pure; thread-safe; allocates.
//
// Means: touchdown as printed. e = vy_LO/|vy_TD|, and with J = (1 + e)|vy_TD|, s the slip, R and alpha of the
// ball: d = (alpha·R²·Δomega - R·Δvx)/J, handed over as the offset at full rolling speed (see
// common/impact/rebound.hpp). The ball slides throughout if |Δvx| < |s|·alpha/(1 + alpha): then
// mu = -Δvx/J. Else it grips: e_x = -s_LO/s_TD, and mu is ample.
//
// Tablet: two-point velocities over T = 3 ms from centres with noise c carry sqrt(2)·c/T in every direction,
// along the flight besides v times the relative noise of the mean diameter, across it v times the noise of
// the surface line's angle; spins sqrt(2)·q/T from equators with noise q. c is the largest (at most 0.5 mm)
// for which none of these exceeds 90 % of the published sd it is part of; likewise q (at most 1 degree).
//
// Machine: sd² - noise², cut off at 0, in speed, angle and spin.
//
// Bounce: what is left of the variances of vy_LO, vx_LO and omega_LO after the noise and what the machine's
// spread makes of them to first order, cut off at 0, is explained by e for vy_LO, and by e_x (sliding: mu)
// and the offset for the other two; of all correlations of these the one is taken that spreads the offset
// least.
//
// Dwell time: sd² less the noise of two straight paths' ends, cut off at 0.
#pragma once

#include <string>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "common/reduction/readout.hpp"
#include "sim/rig/scene.hpp"

namespace strobe::sim {

/// Standard deviations of two-point values from the tablet alone.
struct TwoPointNoise {
  double along_mps = 0.0;   ///< of the speed
  double across_rad = 0.0;  ///< of the path's angle
  double spin_radps = 0.0;
};

/// For a leg with that velocity, `diameters` measured diameters, and the scene's tablet.
TwoPointNoise two_point_noise(const Scene& scene, double vx_mps, double vy_mps, double diameters);

/// A quantity whose published spread is less than what tablet and machine make of it.
struct Excess {
  reduction::Quantity quantity = reduction::Quantity::vx_lo_mps;
  double published_sd = 0.0;
  double expected_sd = 0.0;  ///< to first order
};

struct FittedScene {
  Scene scene;
  bool slides = false;
  std::vector<Excess> excesses;  ///< spreads cut off at 0
};

/// Fails if the condition is outside the impact models' ranges.
Result<FittedScene> fit_scene(const thesis::Condition& condition);

/// The scene file's text; what has its default value is left out.
std::string to_toml(const FittedScene& fitted, const thesis::Condition& condition);

}  // namespace strobe::sim
