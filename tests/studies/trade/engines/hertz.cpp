// Hunt and Crossley's contact in long double.
#include <algorithm>
#include <array>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>

#include "tests/studies/trade/engines/engine.hpp"

namespace strobe::studies::trade {

namespace {

using Real = long double;
/// depth, its rate, vx, R omega; without units where calibrated.
using State = std::array<Real, 4>;

template <typename Slope>
State stepped(const Slope& slope, const State& from, Real h) {
  boost::numeric::odeint::runge_kutta_fehlberg78<State, Real, State, Real,
                                                 boost::numeric::odeint::array_algebra>
      stepper;
  State z = from;
  stepper.do_step(slope, z, Real(0), h);
  return z;
}

/// From touchdown to where the depth is zero again; the last step shortened by the secant rule.
template <typename Slope>
std::pair<State, Real> to_release(const Slope& slope, State z, Real h) {
  Real time = 0;
  for (int i = 0; i < 100'000'000; ++i) {
    const State next = stepped(slope, z, h);
    if (next[0] > 0) {
      z = next;
      time += h;
      continue;
    }
    Real part = h * z[0] / (z[0] - next[0]);
    State end = stepped(slope, z, part);
    for (int k = 0; k < 6; ++k) {
      part -= end[0] / end[1];
      end = stepped(slope, z, part);
    }
    return {end, time + part};
  }
  return {z, time};
}

/// y'' = -y^1.5·(1 + q·y'), y' = 1 at first: e and the dwell time without units.
struct Shape {
  Real e, dwell;
};

Shape shape_of(Real q) {
  const auto slope = [q](const State& z, State& d, Real) {
    const Real depth = std::max<Real>(z[0], 0);
    d = {z[1], -std::max<Real>(0, depth * std::sqrt(depth) * (1 + q * z[1])), 0, 0};
  };
  const auto [end, dwell] = to_release(slope, {0, 1, 0, 0}, Real(5e-3));
  return {-end[1], dwell};
}

}  // namespace

HertzContact hertz_contact(const EngineBounce& b, double transition_mps) {
  Real low = 0, high = 3;
  for (int i = 0; i < 40; ++i) {
    const Real middle = (low + high) / 2;
    (shape_of(middle).e > b.e ? low : high) = middle;
  }
  const Shape shape = shape_of(low);
  const Real speed = -b.touchdown.vy_mps;
  // Time's unit tau: m·speed/tau = stiffness·(speed·tau)^1.5.
  const Real tau = b.dwell_s / shape.dwell;
  HertzContact contact;
  contact.stiffness = static_cast<double>(b.ball.mass_kg * speed / tau / std::pow(speed * tau, Real(1.5)));
  contact.dissipation_spm = static_cast<double>(low / (Real(1.5) * speed));
  contact.transition_mps = transition_mps;
  return contact;
}

impact::Motion hertz_lift_off(const EngineBounce& b, int steps) {
  const HertzContact& c = b.hertz;
  const Real radius = b.ball.radius_m(), mass = b.ball.mass_kg;
  const auto slope = [&](const State& z, State& d, Real) {
    const Real depth = std::max<Real>(z[0], 0);
    const Real force = c.stiffness * depth * std::sqrt(depth) * (1 + Real(1.5) * c.dissipation_spm * z[1]);
    const Real lever = (radius - depth) / radius, slip = z[2] + lever * z[3];
    const Real friction = b.mu * force * std::clamp<Real>(slip / c.transition_mps, -1, 1);
    d = {z[1], -std::max<Real>(0, force) / mass, -friction / mass,
         -lever * friction / (Real(b.ball.alpha) * mass)};
  };
  const State start{0, -b.touchdown.vy_mps, b.touchdown.vx_mps, radius * b.touchdown.omega_radps};
  const State end = to_release(slope, start, Real(b.dwell_s) / steps).first;
  return {static_cast<double>(end[2]), static_cast<double>(-end[1]), static_cast<double>(end[3] / radius)};
}

}  // namespace strobe::studies::trade
