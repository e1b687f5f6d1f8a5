// Whether the images in contact lie where the surface line has them.
#include <algorithm>
#include <cmath>

#include "common/reduction/surface_check.hpp"

namespace strobe::reduction {
namespace {

/// One-sided, 1e-4 of normal errors: some ten comparisons in a photograph, one false alarm in a thousand.
constexpr double kSigmas = 3.72;
/// A ball this near to touching, in its diameters, may be taken for one that touches, and the other way round: the
/// order of digitizing by hand.
constexpr double kLabelledByEye = 0.01;

/// A place in the levelled photograph, with the gradient of its height and a variance beyond that of the fit. [m]
struct Place {
  Eigen::Vector2d at_m;
  JointVector gradient{};
  double variance_m2 = 0.0;
};

/// Of a centre there above one that touches, in the ball's diameters.
double clearance(const ShotFit& fit, const Place& place) {
  const double diameter = fit.observations.ball_diameter_m * fit.joint.unknowns[kScale];
  return surface_residual(fit.joint, place.at_m) / diameter - 0.5;
}

/// Of the clearance. The tilt's second order is left out.
double sd_of(const ShotFit& fit, const Place& place) {
  const double diameter = fit.observations.ball_diameter_m * fit.joint.unknowns[kScale];
  JointVector gradient = place.gradient;
  gradient[kTilt] -= surface_lever_m(fit.joint, place.at_m);
  gradient[kHeight] -= 1.0;
  if (!fit.observations.scale_exact())
    gradient[kScale] -= surface_residual(fit.joint, place.at_m) / fit.joint.unknowns[kScale];
  const auto y = fit.joint.factor.whitened(gradient);
  return std::sqrt(dot(y, y) + place.variance_m2) / diameter;
}

/// Whether the clearance is beyond zero upward, or beyond minus a radius downward.
bool above_touch(const ShotFit& fit, const Place& place) {
  const double by = clearance(fit, place) - kLabelledByEye;
  return by > 0.0 && by > kSigmas * sd_of(fit, place);
}
bool beneath_surface(const ShotFit& fit, const Place& place) {
  const double by = -0.5 - clearance(fit, place) - kLabelledByEye;
  return by > 0.0 && by > kSigmas * sd_of(fit, place);
}

/// Where the ball would be had it flown on along that leg.
Place on_path(const ShotFit& fit, std::size_t leg, const Observation& o) {
  const double s = fit.joint.legs[leg].scaled(o.time_s);
  const double t = s * fit.joint.legs[leg].span_s;
  const double* z = &fit.joint.unknowns[kLegStart[leg]];
  const flight::Forcing& forcing = fit.joint.forcing[leg];
  const Eigen::Vector2d bend =
      fit.joint.unknowns[kScale] * t * t * (0.5 * forcing.acceleration_mps2 + t * forcing.jerk_mps3 / 6.0);
  Place place{{z[0] + z[2] * s + bend.x(), z[1] + z[3] * s + bend.y()}};
  place.gradient[kLegStart[leg] + 1] = 1.0;
  place.gradient[kLegStart[leg] + 3] = s;
  const double by_time = o.time_sd_s * z[3] / fit.joint.legs[leg].span_s;
  place.variance_m2 = by_time * by_time;
  return place;
}

bool contradicts(const ShotFit& fit, const Observation& o) {
  const Place own{o.centre_m, {}, fit.observations.centre_variance(o)};
  return above_touch(fit, own) || beneath_surface(fit, own) || above_touch(fit, on_path(fit, 0, o)) ||
         above_touch(fit, on_path(fit, 1, o));
}

}  // namespace

bool contact_contradicts_surface(const ShotFit& fit) {
  if (fit.joint.degenerate || !fit.joint.legs[0].fitted || !fit.joint.legs[1].fitted) return false;
  return std::any_of(fit.observations.images.begin(), fit.observations.images.end(),
                     [&](const Observation& o) { return o.leg == Leg::contact && contradicts(fit, o); });
}

}  // namespace strobe::reduction
