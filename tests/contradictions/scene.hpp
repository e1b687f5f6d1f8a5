// What happened before a camera, and what is told of it: drawn at random, true and told alike unless they are
// made to differ. The ball's flight through air is by direct integration (Runge and Kutta's fourth order),
// and shares no code with what it tests. Axes: x in the direction of travel, y up from the surface, spin
// counter-clockwise positive (backspin). Pure functions of plain values: thread-safe.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>

#include "sim/random/draws.hpp"

namespace strobe::contradictions {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180.0;

struct Motion {
  double x_m = 0.0, y_m = 0.0;
  double vx_mps = 0.0, vy_mps = 0.0;
  double angle_rad = 0.0;  ///< of the equator
  double omega_radps = 0.0;
};

/// dv/dt = g - q C_D |v| v + q C_L |v| (z x v), q = density pi R^2 / (2 m), C_L = R omega / (2 R |omega| +
/// |v|); domega/dt = -decay |v| omega.
struct Forces {
  double gx_mps2 = 0.0, gy_mps2 = 0.0;
  double drag_per_m = 0.0;  ///< q C_D
  double lift_per_m = 0.0;  ///< q
  double decay_per_m = 0.0;
  double radius_m = 0.0325;
};

/// By gravity, drag, Magnus lift and the spin's decay: the motion `duration_s` later, or earlier where it is
/// negative. Steps of at most 2 ms: forces change by some hundredths in one, so that the error is below 1e-10
/// of the forces' part.
Motion flown(const Motion& from, const Forces& forces, double duration_s);

/// Draws of one shot, repeatable from its seed with every compiler and library. Plain value: thread-safe per
/// object.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream, std::uint64_t shot)
      : key_(sim::hash64(sim::hash64(sim::hash64(seed) + stream) + shot)) {}

  /// Uniform in (0, 1).
  double uniform() {
    const std::uint64_t bits = sim::hash64(key_ + sim::kSplitMixStep * ++count_) >> 11;
    return (static_cast<double>(bits) + 0.5) * 0x1p-53;
  }
  double within(double least, double most) { return least + (most - least) * uniform(); }
  /// Its logarithm is uniform. Both > 0.
  double logarithmic(double least, double most) { return least * std::pow(most / least, uniform()); }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  bool chance(double probability) { return uniform() < probability; }
  /// One of 0 .. count - 1. count > 0.
  std::size_t index(std::size_t count) {
    return static_cast<std::size_t>(uniform() * static_cast<double>(count));
  }
  int integer(int least, int most) {
    return least + static_cast<int>(index(static_cast<std::size_t>(most - least + 1)));
  }

  /// Standard normal (Box and Muller 1958).
  double normal() {
    if (kept_) {
      kept_ = false;
      return kept_value_;
    }
    const double radius = std::sqrt(-2.0 * std::log(uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    kept_ = true;
    kept_value_ = radius * std::sin(angle);
    return radius * std::cos(angle);
  }
  /// Student's t with three degrees of freedom; its variance is 3.
  double student_3() {
    const double top = normal();
    const double a = normal(), b = normal(), c = normal();
    return top / std::sqrt((a * a + b * b + c * c) / 3.0);
  }

 private:
  std::uint64_t key_;
  std::uint64_t count_ = 0;
  bool kept_ = false;
  double kept_value_ = 0.0;
};

enum class NoiseLevel { hand, digitizer };

struct Settings {
  NoiseLevel noise = NoiseLevel::hand;
  int least_images = 2, most_images = 40;  ///< of a leg, at least 2
  bool noise_stated = true;                ///< false: frames without any sd of the measurements
};

/// Impact of a sphere: restitution e, friction mu, a tangential restitution e_x, and the normal force
/// `offset_m` ahead of the centre.
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
  std::optional<double> told_fastest_spin_radps = 630.0;  ///< before the bounce
  // Air, plate.
  double drag_coefficient = 0.55, lift_factor = 1.0, spin_decay_per_m = 0.01, temperature_c = 20.0;
  bool tell_temperature = true;
  double inclination_deg = 0.0, told_inclination_deg = 0.0;  ///< as the camera sees it
  ImpactParameters impact;
  // Camera.
  double px_per_m = 3000.0, tilt_rad = 0.0;
  bool to_the_left = false;
  std::optional<double> told_px_per_m, told_px_per_m_sd;
  // The third dimension, z towards the camera: spin across the camera's axis over that along it, before and after the
  // bounce; the line's plane at the surface; velocity towards the lens, which is that far away (0: infinitely).
  bool line_measured = false;
  double spin_x_ratio[2] = {0.0, 0.0}, spin_y_ratio[2] = {0.0, 0.0};
  double line_out_rad = 0.0;
  double vz_mps[2] = {0.0, 0.0};
  double lens_m = 0.0;
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

/// An undisturbed scene: what is told is true within its stated tolerance, air and alpha are as assumed, the
/// spins below 80 % of what the train resolves.
Scene drawn_scene(const Settings& settings, Random& random);

/// Makes the period so long, up to 15 ms, that most spins exceed what the train resolves.
void lengthen_period(Scene& scene, Random& random);

/// Lets the ball spin faster than any in play, and the period be 1 to 6 ms.
void spin_fast(Scene& scene, bool coded, Random& random);

}  // namespace strobe::contradictions
