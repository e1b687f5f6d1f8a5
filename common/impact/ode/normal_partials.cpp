#include "common/impact/ode/normal_partials.hpp"

namespace strobe::impact::detail {

namespace {

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
  const double turned = turned_by_series(omega2, tau)
                            ? std::exp(-zeta * tau) * turned_sine_series(omega2, tau)
                            : (o.sine - tau * o.cosine) / omega2;
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
