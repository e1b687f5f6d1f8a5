// A frame as the fits see it: in the surface's axes, in metres, time from the first image, each measurement
// with its noise. Part of the reduction, not of its interface. Plain values; thread-safe.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/ball/ball.hpp"
#include "common/flight/aerodynamics.hpp"
#include "common/geometry/line.hpp"
#include "common/reduction/flags.hpp"
#include "common/reduction/frame.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {

/// Measurements that share one unknown factor of their variances. `stated` is noise that came with the frame
/// and is believed; the others' variance components are estimated from the residuals.
enum class NoiseGroup { stated, centre, surface, diameter, equator };
inline constexpr std::size_t kNoiseGroupCount = 5;

/// One degree: what a person who digitizes an equator does.
inline constexpr double kUsualEquatorSd_rad = 0.0175;

/// Without a surface only the camera tells the vertical: of one that was levelled by eye or by its bubble.
inline constexpr double kCameraRollSd_rad = radians(1.0);

/// Standard deviations of the groups that are not stated, in units of the measurements' own ones: these are 1
/// m or 1 rad, or what the frame states where that is taken for a relative weight.
struct GroupSds {
  std::array<double, kNoiseGroupCount> sd{};
  double operator[](NoiseGroup n) const { return sd[static_cast<std::size_t>(n)]; }
  double& operator[](NoiseGroup n) { return sd[static_cast<std::size_t>(n)]; }
};

/// Lower triangular Cholesky factor L of a 2x2 covariance L L^T. Kept instead of the covariance, whose
/// smaller variance a rotation would round away beside the larger.
struct CholeskyFactor {
  double xx = 0.0;
  double yx = 0.0;
  double yy = 0.0;
};

struct Observation {
  double time_s = 0.0;
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double diameter_m = 0.0;
  double equator_rad = 0.0;
  // To be multiplied by the group's standard deviation, 1 for `stated`.
  CholeskyFactor centre_cholesky_m{1.0, 0.0, 1.0};
  double diameter_sd_m = 1.0;
  double equator_sd_rad = 1.0;
  double time_sd_s = 0.0;
  NoiseGroup centre_noise = NoiseGroup::stated;
  NoiseGroup diameter_noise = NoiseGroup::stated;
  NoiseGroup equator_noise = NoiseGroup::stated;
  bool digitized = false;             ///< a digitizer states its sds, image by image
  std::optional<double> probability;  ///< BallImage::probability
  std::optional<Leg> leg;
  bool use_centre = false;  ///< airborne and not left out
  bool use_diameter = false;
  bool use_equator = false;
};

/// The fastest rim of a ball in play: 6,000 revolutions a minute of a tennis ball, a fifth more than the
/// strongest topspin filmed (4,900: J. Yandell, high-speed films of professional forehands). Machines can do
/// more.
inline constexpr double kFastestRim_mps = 20.5;

/// A MapError in the surface's axes.
struct ObservedMapError {
  struct Shift {
    Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
    double diameter_m = 0.0;
    double equator_rad = 0.0;
  };
  std::vector<Shift> images;
  std::vector<Eigen::Vector2d> surface_m;
};

/// Without a surface the axes are the photograph's, from its first image, and all images are the incoming
/// leg's.
struct Observations {
  std::vector<Observation> images;
  std::vector<Eigen::Vector2d> surface_m;
  double surface_sd_m = 1.0;  ///< to be multiplied likewise
  NoiseGroup surface_noise = NoiseGroup::stated;
  double ball_diameter_m = 0.0;
  std::optional<double> ball_diameter_sd_m;
  std::optional<double> shared_diameter_sd_m;              ///< Frame::shared_diameter_sd_px
  std::optional<double> scale;                             ///< calibrated px per m over the surface frame's
  double scale_sd = 0.0;                                   ///< 0: exact
  Eigen::Vector2d gravity_mps2 = Eigen::Vector2d::Zero();  ///< in the surface's axes
  ball::Ball ball;
  std::vector<ObservedMapError> map_errors;
  double alpha_sd = ball::kAlphaSd;
  std::optional<double> stated_fastest_radps;  ///< Frame::fastest_spin_radps
  double air_density_kgpm3 = flight::kAirDensity_kgpm3;
  flight::AirLaw air_law;
  bool line_drawn = true;
  geometry::SurfaceFrame surface;
  GroupSds group_sd;

  /// As stated, else as any ball's in play.
  double fastest_spin_radps() const {
    return stated_fastest_radps.value_or(kFastestRim_mps / ball.radius_m());
  }
  bool has_surface() const { return !surface_m.empty(); }
  bool scale_exact() const { return scale && scale_sd == 0.0; }
  /// Of the ball's diameter against all that are measured alike.
  double size_sd_m() const {
    return std::hypot(ball_diameter_sd_m.value_or(0.0), shared_diameter_sd_m.value_or(0.0));
  }
  double unit(NoiseGroup noise) const { return noise == NoiseGroup::stated ? 1.0 : group_sd[noise]; }
  double centre_variance(const Observation& o) const {
    const CholeskyFactor& l = o.centre_cholesky_m;
    const double u = unit(o.centre_noise);
    return u * u * (0.5 * (l.xx * l.xx + l.yx * l.yx + l.yy * l.yy));
  }
  double diameter_sd(const Observation& o) const { return unit(o.diameter_noise) * o.diameter_sd_m; }
  double equator_sd(const Observation& o) const { return unit(o.equator_noise) * o.equator_sd_rad; }
  double surface_sd() const { return unit(surface_noise) * surface_sd_m; }
};

/// Measurements in the surface's axes, with the images' legs; sets the flags of what it found. Returns
/// nullopt if no line goes through the surface points (flag degenerate_geometry). The frame must be valid.
std::optional<Observations> observe(const Frame& frame, FlagSet& flags,
                                    NoiseSource noise = NoiseSource::stated);

/// Of a displacement or a velocity along the path. A ball within 3 degrees of the vertical has no direction
/// of travel: false.
bool travels_left(const Eigen::Vector2d& way);

/// As a mirror at the surface's normal shows them: a ball that travelled to the left then travels to the
/// right.
void mirror(Observations& all);

/// All measurements as so many standard deviations of one of the map's errors move them.
void shift(const ObservedMapError& error, double sds, Observations& all);

}  // namespace strobe::reduction
