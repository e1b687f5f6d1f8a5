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

/// Height of a centre above one that touches, over the ball's diameter, and its variance.
struct Clearance {
  double value = 0.0;
  double variance = 0.0;

  bool above(double limit) const { return value - limit > kLabelledByEye + kSigmas * std::sqrt(variance); }
  bool below(double limit) const { return limit - value > kLabelledByEye + kSigmas * std::sqrt(variance); }
};

/// Of a place in the levelled photograph with the given gradient of its height. The tilt's second order is left out.
Clearance clearance(const ShotFit& fit, const Eigen::Vector2d& place, JointVector gradient) {
  const double diameter = fit.observations.ball_diameter_m * fit.joint.unknowns[kScale];
  const double height = surface_residual(fit.joint, place);
  gradient[kTilt] -= surface_lever_m(fit.joint, place);
  gradient[kHeight] -= 1.0;
  if (!fit.observations.scale_exact()) gradient[kScale] -= height / fit.joint.unknowns[kScale];
  const auto y = fit.joint.factor.whitened(gradient);
  return {height / diameter - 0.5, dot(y, y) / (diameter * diameter)};
}

Clearance of_image(const ShotFit& fit, const Observation& o) {
  Clearance c = clearance(fit, o.centre_m, {});
  const double diameter = fit.observations.ball_diameter_m * fit.joint.unknowns[kScale];
  c.variance += fit.observations.centre_variance(o) / (diameter * diameter);
  return c;
}

/// Of the ball had it flown on along that leg.
Clearance of_path(const ShotFit& fit, std::size_t leg, const Observation& o) {
  const double s = fit.joint.legs[leg].scaled(o.time_s);
  const double t = s * fit.joint.legs[leg].span_s;
  const double* z = &fit.joint.unknowns[kLegStart[leg]];
  const double scale = fit.joint.unknowns[kScale];
  const flight::Forcing& forcing = fit.joint.forcing[leg];
  const Eigen::Vector2d bend =
      scale * t * t * (0.5 * forcing.acceleration_mps2 + t * forcing.jerk_mps3 / 6.0);
  JointVector gradient{};
  gradient[kLegStart[leg] + 1] = 1.0;
  gradient[kLegStart[leg] + 3] = s;
  Clearance c = clearance(fit, {z[0] + z[2] * s + bend.x(), z[1] + z[3] * s + bend.y()}, gradient);
  const double by_time = o.time_sd_s * z[3] / fit.joint.legs[leg].span_s;
  const double diameter = fit.observations.ball_diameter_m * scale;
  c.variance += by_time * by_time / (diameter * diameter);
  return c;
}

bool contradicts(const ShotFit& fit, const Observation& o) {
  const Clearance own = of_image(fit, o);
  if (own.above(0.0) || own.below(-0.5)) return true;
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (of_path(fit, leg, o).above(0.0)) return true;
  }
  return false;
}

}  // namespace

bool contact_contradicts_surface(const ShotFit& fit) {
  if (fit.joint.degenerate || !fit.joint.legs[0].fitted || !fit.joint.legs[1].fitted) return false;
  return std::any_of(fit.observations.images.begin(), fit.observations.images.end(),
                     [&](const Observation& o) { return o.leg == Leg::contact && contradicts(fit, o); });
}

}  // namespace strobe::reduction
