// What happened before a camera, and what is told of it: drawn at random, true and told alike unless they are made to
// differ. Axes as for flight.hpp. Pure functions of plain values: thread-safe.
#pragma once

#include <optional>

#include "tests/contradictions/flight.hpp"
#include "tests/contradictions/random.hpp"

namespace strobe::contradictions {

enum class NoiseLevel { hand, digitizer };

struct Settings {
  NoiseLevel noise = NoiseLevel::hand;
  int least_images = 2, most_images = 40;  ///< of a leg, at least 2
  bool noise_stated = true;                ///< false: frames without any sd of the measurements
};

/// Impact of a sphere: restitution e, friction mu, a tangential restitution e_x, and the normal force `offset_m` ahead
/// of the centre.
struct ImpactParameters {
  double vx_mps = 15.0, vy_mps = -7.0, omega_radps = 0.0;  ///< at touchdown
  double e = 0.75, mu = 0.55, e_x = 0.0, offset_m = 0.0;
  double dwell_s = 5e-3;
  double path_factor = 1.0;  ///< dwell distance over the mean of both velocities times the dwell time
};

/// Standard deviations in px and rad.
struct Noise {
  double centre_px = 1.0, diameter_px = 1.0, equator_rad = 0.0175, surface_px = 1.0;
};

struct Scene {
  // The ball.
  double diameter_m = 0.0651, told_diameter_m = 0.0651;
  std::optional<double> told_diameter_sd_m;
  double mass_kg = 0.0576, alpha = 0.55;
  std::optional<double> told_alpha;  ///< absent: 0.55 is assumed
  // Air, plate.
  double drag_coefficient = 0.55, lift_factor = 1.0, spin_decay_per_m = 0.01, temperature_c = 20.0;
  bool tell_temperature = true;
  double inclination_deg = 0.0, told_inclination_deg = 0.0;  ///< as the camera sees it
  ImpactParameters impact;
  // Camera.
  double px_per_m = 3000.0, tilt_rad = 0.0;
  bool to_the_left = false;
  std::optional<double> told_px_per_m, told_px_per_m_sd;
  int surface_points = 4;
  // Flash train.
  double period_s = 3e-3;
  bool coded = false;
  int incoming = 5, rebound = 5;
  // What is written down.
  bool labels = true, contact_images = true, noise_stated = true, noise_by_image = false;
  bool flash_indices = false;
  double time_sd_s = 0.0;  ///< stated with each image, if above 0
  bool heavy_tails = false;
  Noise stated, true_over_stated{1.0, 1.0, 1.0, 1.0};

  double radius_m() const { return 0.5 * diameter_m; }
  double told_alpha_or_default() const { return told_alpha.value_or(0.55); }
};

/// Of both ends of the contact.
struct Bounce {
  Motion td, lo;  ///< td.x_m is 0; both centres are one radius above the surface
  bool slid = false;
};

Bounce bounce(const Scene& scene);
Forces forces(const Scene& scene);

/// An undisturbed scene: what is told is true within its stated tolerance, air and alpha are as assumed, the spins below
/// 80 % of what the train resolves.
Scene drawn_scene(const Settings& settings, Random& random);

/// Makes the period so long, up to 15 ms, that most spins exceed what the train resolves.
void lengthen_period(Scene& scene, Random& random);

}  // namespace strobe::contradictions
