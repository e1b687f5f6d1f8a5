// A frame as the fits see it: levelled, in metres, time from the first image, each measurement with its
// noise. Part of the reduction, not of its interface. Plain values; thread-safe.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/ball/ball.hpp"
#include "common/flight/aerodynamics.hpp"
#include "common/reduction/flags.hpp"
#include "common/reduction/frame.hpp"
#include "common/reduction/levelling.hpp"

namespace strobe::reduction {

/// Measurements that share one noise level. `stated` is noise that came with the frame; the others are levels
/// that must be estimated from the residuals.
enum class Noise { stated, centre, surface, diameter, equator };
inline constexpr std::size_t kNoiseCount = 5;

/// Standard deviations of the levels that are not stated. [m, m, m, rad]
struct NoiseLevels {
  std::array<double, kNoiseCount> sd{};
  double operator[](Noise n) const { return sd[static_cast<std::size_t>(n)]; }
  double& operator[](Noise n) { return sd[static_cast<std::size_t>(n)]; }
};

/// Lower triangular root L of a 2x2 covariance L L^T. Kept instead of the covariance, whose smaller variance
/// a rotation would round away beside the larger.
struct Root {
  double xx = 0.0;
  double yx = 0.0;
  double yy = 0.0;
};

struct Observation {
  double time_s = 0.0;
  Vec2 centre_m;
  double diameter_m = 0.0;
  double equator_rad = 0.0;
  Root centre_cholesky_m;       ///< if stated
  double diameter_sd_m = 0.0;   ///< if stated
  double equator_sd_rad = 0.0;  ///< if stated
  double time_sd_s = 0.0;
  Noise centre_noise = Noise::stated;
  Noise diameter_noise = Noise::stated;
  Noise equator_noise = Noise::stated;
  std::optional<Leg> leg;
  bool use_centre = false;  ///< airborne and not left out
  bool use_diameter = false;
  bool use_equator = false;
};

struct Observations {
  std::vector<Observation> images;
  std::vector<Vec2> surface_m;
  double surface_sd_m = 0.0;  ///< if stated
  Noise surface_noise = Noise::stated;
  double ball_diameter_m = 0.0;
  std::optional<double> ball_diameter_sd_m;
  std::optional<double> scale;  ///< calibrated px per m over the levelling's
  double scale_sd = 0.0;        ///< 0: exact
  Vec2 gravity_mps2;            ///< in the surface's axes
  ball::Ball ball;
  double air_density_kgpm3 = flight::kAirDensity_kgpm3;
  Levelling levelling;
  NoiseLevels levels;

  bool scale_exact() const { return scale && scale_sd == 0.0; }
  double centre_variance(const Observation& o) const {
    const Root& l = o.centre_cholesky_m;
    return o.centre_noise == Noise::stated ? 0.5 * (l.xx * l.xx + l.yx * l.yx + l.yy * l.yy)
                                           : levels[Noise::centre] * levels[Noise::centre];
  }
  double diameter_sd(const Observation& o) const {
    return o.diameter_noise == Noise::stated ? o.diameter_sd_m : levels[Noise::diameter];
  }
  double equator_sd(const Observation& o) const {
    return o.equator_noise == Noise::stated ? o.equator_sd_rad : levels[Noise::equator];
  }
  double surface_sd() const { return surface_noise == Noise::stated ? surface_sd_m : levels[surface_noise]; }
};

/// What is wrong with the frame, naming the field; nothing if it can be reduced.
std::optional<std::string> invalid(const Frame& frame);

/// From the frame, or from the session's record if that has a number there within the valid range.
std::optional<double> temperature_c(const Frame& frame);

/// Levels the frame, finds the legs and leaves out what is not airborne; sets the flags of what it found.
/// Nothing if no line goes through the surface points (flag degenerate_geometry). The frame must be valid.
std::optional<Observations> observe(const Frame& frame, FlagSet& flags);

}  // namespace strobe::reduction
