#include "common/impact/ode/normal_partials.hpp"

namespace strobe::impact::detail {

namespace {

/// (sine - t·cosine)/omega2 of the faded oscillation, whatever sign omega2 has.
double turned_sine(double zeta, double omega2, double t, const Oscillation& o) {
  const double z = omega2 * t * t;
  if (std::abs(z) > 0.1) return (o.sine - t * o.cosine) / omega2;
  // The next term is below 1e-13 of the first.
  return std::exp(-zeta * t) * t * t * t *
         (1.0 / 3.0 - z * (1.0 / 30.0 - z * (1.0 / 840.0 - z * (1.0 / 45360.0 - z * (1.0 / 3991680.0)))));
}

/// exp(-zeta·tau) times the two solutions; without gravity they follow from the state.
Oscillation faded_oscillation(const System& s, double omega2, const NormalState& at) {
  if (s.gravity == 0.0) return {at.rate + s.zeta * at.depth, at.depth};
  const Oscillation o = oscillation(omega2, at.tau);
  const double fade = std::exp(-s.zeta * at.tau);
  return {fade * o.cosine, fade * o.sine};
}

}  // namespace

NormalPartials normal_partials(const System& s, const NormalState& at) {
  const double zeta = s.zeta, g = s.gravity, tau = at.tau;
  const double omega2 = (1.0 - zeta) * (1.0 + zeta);
  const Oscillation o = faded_oscillation(s, omega2, at);
  const double turned = turned_sine(zeta, omega2, tau, o);
  const double sine_rate = zeta * turned, cosine_rate = zeta * tau * o.sine;  // with zeta, but for the fading
  const double force = at.depth + 2.0 * zeta * at.rate;
  NormalPartials p;
  p.zeta.depth = -tau * (at.depth - g) - g * (cosine_rate + o.sine) + (1.0 - g * zeta) * sine_rate;
  p.zeta.rate = -tau * at.rate + cosine_rate - o.sine + (g - zeta) * sine_rate;
  p.zeta.force = p.zeta.depth + 2.0 * at.rate + 2.0 * zeta * p.zeta.rate;
  p.zeta.force_rate = p.zeta.rate + 2.0 * (g - force) - 2.0 * zeta * p.zeta.force;
  p.zeta.impulse = -p.zeta.rate;
  p.zeta.impulse_integral = -p.zeta.depth;
  p.gravity.depth = 1.0 - o.cosine - zeta * o.sine;
  p.gravity.rate = o.sine;
  p.gravity.force = p.gravity.depth + 2.0 * zeta * p.gravity.rate;
  p.gravity.force_rate = p.gravity.rate + 2.0 * zeta * (1.0 - p.gravity.force);
  p.gravity.impulse = tau - p.gravity.rate;
  p.gravity.impulse_integral = 0.5 * tau * tau - p.gravity.depth;
  return p;
}

}  // namespace strobe::impact::detail
