// Photographs of a ball whose motion is known exactly, for tests of the reduction. Written from the equations
// of motion alone; shares no code with what it tests.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"

namespace strobe::test {

/// A bounce in the surface's axes, touchdown at time 0 and x = 0.
struct Bounce {
  std::string label;
  double vx_td = 15.62, vy_td = -6.71, omega_td = 2.61;
  double vx_lo = 8.84, vy_lo = 5.76, omega_lo = -313.2;
  double dwell_s = 5.20e-3, dwell_x_m = 0.0629, diameter_m = 0.0651;
};

/// What the air does to the ball: dv/dt = g - q·C_D·|v|·v + q·C_L·|v|·(z × v), q = density·pi·R²/(2·mass),
/// C_L = R·omega/(2·R·|omega| + |v|). Dry air at 20 degrees Celsius.
struct Air {
  double drag_coefficient = 0.55;
  bool lift = true;
  double density_kgpm3 = 1.204, mass_kg = 0.0576;
  double spin_decay_per_m = 0.01;  ///< domega/dt = -spin_decay_per_m·|v|·omega, at 1.204 kg/m³
};

/// A camera, a flash train and a person who digitizes.
struct Setup {
  double px_per_m = 4000.0, roll_rad = 0.005, origin_x_px = 1200.0, origin_y_px = 300.0;
  double period_s = 3.0e-3;
  double phase = 0.4;  ///< of a period between the last flash before touchdown and touchdown
  int incoming = 5, rebound = 5;
  double incline_rad = 0.0;  ///< of the plate
  double gravity_mps2 = 9.80665;
  Air air;
  std::vector<double> surface_x_m = {-0.20, -0.12, 0.18, 0.26};
  double time_origin_s = 0.0;
  std::optional<double> fastest_spin_radps = 630.0;  ///< stated, before the bounce
  bool mirror = false, labels = true, state_noise = true;
  // Noise of digitizing by hand: half a millimetre, one degree.
  double centre_sd_m = 0.5e-3, diameter_sd_m = 0.5e-3, equator_sd_rad = 0.0175, surface_sd_m = 0.5e-3;
  double flash_jitter_s = 0.0;    ///< of the true flash times; the frame has them exactly
  double late_before_td_s = 0.0;  ///< by how much the last flash before touchdown is late; the frame says so
  double noise_factor = 1.0;      ///< of the noise added, not of that stated
};

/// All bounces of the thesis's tables, as means of their series.
std::vector<Bounce> thesis_bounces();

using Random = std::mt19937_64;

/// STROBE_SEED from the environment, which repeats a run, or the test's own seed.
std::uint64_t seed_or(std::uint64_t own);

reduction::Frame photograph(const Bounce& bounce, const Setup& setup, Random& random);

/// What a perfect reduction reads.
reduction::Quantities truth(const Bounce& bounce);

/// One flight alone, without a surface: that before the bounce, which may rise as well.
reduction::Frame flight_alone(const Bounce& bounce, Setup setup, Random& random);

/// What a perfect reduction reads of it, in the places of the numbers at touchdown: velocity in the
/// photograph's axes (of a mirrored one seen from the other side) and spin at its first image.
reduction::Quantities launch_truth(const Bounce& bounce, const Setup& setup);

/// Lower bound of any unbiased estimator's standard deviation (Cramer-Rao) for each quantity, from the Fisher
/// information of the fifteen unknowns by numerical differentiation of the photograph.
reduction::Quantities cramer_rao(const Bounce& bounce, const Setup& setup);

}  // namespace strobe::test
