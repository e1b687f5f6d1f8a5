// Implementation of rebound.hpp and spatial_rebound.hpp: friction's impulse and the offset's, along the
// surface, as numbers in the plane or as vectors of two. Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>

#include "common/impact/closed_form/rebound.hpp"

namespace strobe::impact::detail {

std::optional<InputError> find_error(const ball::Ball& ball, const Motion& touchdown, const Coefficients& c);

template <class Vector>
double dot(const Vector& a, const Vector& b) {
  if constexpr (std::is_same_v<Vector, double>)
    return a * b;
  else
    return a.dot(b);
}

/// The vector itself or, where it is longer than the limit, what the limit leaves of it.
template <class Vector>
Vector limited(const Vector& value, double limit) {
  if constexpr (std::is_same_v<Vector, double>) {
    return std::clamp(value, -limit, limit);
  } else {
    const double length = value.norm();
    return length > limit ? Vector(value * (limit / length)) : value;
  }
}

/// Friction's impulse per mass, and whether it suffices for the contact point to grip.
template <class Vector>
struct Friction {
  Vector dv;
  bool grips;
};

/// `moment` = d·J/R: the angular impulse of the normal force over R, per mass.
template <class Vector>
Friction<Vector> friction_impulse(double alpha, const Vector& slip, double e_x, double limit,
                                  const Vector& moment) {
  const Vector needed = -((1.0 + e_x) * slip * alpha + moment) / (1.0 + alpha);
  const Vector dv = limited(needed, limit);
  return {dv, dv == needed};
}

/// The impact with the normal force under the centre, and the offset's effect on it.
template <class Vector>
struct OffsetEffect {
  Friction<Vector> without;
  Friction<Vector> with;
  Vector slip_without;  ///< slip at lift-off
  Vector dv;            ///< changes of v and w = R·omega by the offset
  Vector dspin;
};

/// Differences are expanded to keep their digits: the slip after a grip is -e_x·slip however small the slip
/// is beside the speeds, and the offset's effect is not the difference of two larger numbers.
template <class Vector>
OffsetEffect<Vector> offset_effect(double alpha, const Vector& slip, const Coefficients& c, double limit,
                                   const Vector& moment) {
  OffsetEffect<Vector> s;
  s.without = friction_impulse<Vector>(alpha, slip, c.e_x, limit, 0.0 * moment);
  s.with = friction_impulse(alpha, slip, c.e_x, limit, moment);
  if (s.without.grips)
    s.slip_without = -c.e_x * slip;
  else
    s.slip_without = slip + s.without.dv * (1.0 + 1.0 / alpha);
  if (s.without.grips && s.with.grips)
    s.dv = -moment / (1.0 + alpha);
  else
    s.dv = s.with.dv - s.without.dv;
  s.dspin = (s.dv + moment) / alpha;
  return s;
}

/// Largest fraction, 0…1, of the offset's effect that does not raise the tangential energy above that before
/// the impact. The change of energy is a convex parabola in the fraction x, a·x² + b·x + c: c is the change
/// without offset (never a gain), b·x the work of friction and of the moment. Its root is continuous in the
/// inputs; of its two forms the one is used that adds numbers of like sign.
template <class Vector>
double max_offset_fraction(double alpha, const Vector& slip, double e_x, const Vector& spin,
                           const Vector& moment, const OffsetEffect<Vector>& s) {
  const Vector& dv = s.without.dv;
  const double a = 0.5 * (dot<Vector>(s.dv, s.dv) + dot<Vector>(alpha * s.dspin, s.dspin));
  const double b = dot<Vector>(s.dv, s.slip_without) + dot<Vector>(moment, spin + dv / alpha);
  const double c = s.without.grips
                       ? dot<Vector>(-0.5 * (1.0 - e_x) * (1.0 + e_x) * slip, slip) * (alpha / (1.0 + alpha))
                       : std::min(0.0, 0.5 * dot<Vector>(dv, slip + s.slip_without));
  if (a + b + c <= 0.0 || a == 0.0) return 1.0;
  const double root = std::sqrt(b * b - 4.0 * a * c);
  return std::clamp(b > 0.0 ? -2.0 * c / (b + root) : (root - b) / (2.0 * a), 0.0, 1.0);
}

/// Changes along the surface by one impact.
template <class Vector>
struct GripImpulse {
  Vector dv;     ///< of v
  Vector dspin;  ///< of w = R·omega
  Vector slip_lo;
  Vector offset;  ///< of the normal force, that acted
  bool grips;
};

/// `slip`: v + w; `spin`: w; `rolling`: (v - w)/2; `impulse`: the normal one, per mass.
template <class Vector>
GripImpulse<Vector> grip_impulse(const ball::Ball& ball, const Vector& slip, const Vector& spin,
                                 const Vector& rolling, double impulse, const Coefficients& c) {
  const Vector offset =
      c.offset_m * rolling / std::hypot(std::sqrt(dot(rolling, rolling)), c.offset_reference_mps);
  const Vector moment = offset * impulse / ball.radius_m();
  const OffsetEffect<Vector> effect = offset_effect(ball.alpha, slip, c, c.mu * impulse, moment);
  const double fraction = moment == Vector(0.0 * moment)
                              ? 1.0
                              : max_offset_fraction(ball.alpha, slip, c.e_x, spin, moment, effect);
  GripImpulse<Vector> out;
  out.dv = effect.with.dv;
  if (fraction < 1.0) out.dv = effect.without.dv + fraction * effect.dv;
  out.dspin = (out.dv + fraction * moment) / ball.alpha;
  out.grips = (fraction < 1.0 ? effect.without : effect.with).grips;
  if (fraction == 1.0 && out.grips)
    out.slip_lo = -c.e_x * slip;
  else
    out.slip_lo = slip + out.dv + out.dspin;
  out.offset = fraction * offset;
  return out;
}

}  // namespace strobe::impact::detail
