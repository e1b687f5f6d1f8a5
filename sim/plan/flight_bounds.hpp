// How gravity, drag, Magnus lift and spin decay displace an image of a ball that is t from the surface
// (before touchdown or after lift-off, where a simulation with the effect and one without it agree). Pure,
// thread-safe, no allocation. Source: the equation of motion of sim/motion/flight.hpp and Groenwall's
// inequality.
//
// Speeds. |dv/dt| <= g + kappa·|v|², kappa = hypot(q·C_D, q/2), since C_L <= 1/2. The solution of dV/dt =
// kappa·V² through V(0) = v0 + g·t grows by at least g·dt more for every dt in its start, hence
//   |v| <= V = (v0 + g·t)/(1 - kappa·(v0 + g·t)·t)     on the whole leg, forwards and backwards in time,
// and the velocity changes by at most A·t, A = g + kappa·V². Where the denominator is not positive there is
// no bound.
//
// Places. Let d be the difference of two flights that agree at the surface, of which one lacks an effect of
// acceleration a(v), and a0 its value at the surface. To first order d = a0·t²/2, whichever way time runs:
// that is `by`. Off it, `within`, by
// - what a changes on the way: |a - a0| <= l·A·t, l its Lipschitz constant, hence l·A·t³/6;
// - what the difference in velocity does to the effects that both have: |d''| <= |a| + L·|d'|, so by
//   Groenwall |d'| <= a_max·t·exp(L·t), hence L·a_max·exp(L·t)·t³/6, a_max = |a0| + l·A·t.
// Drag q·C_D·|v|·v has l = 2·q·C_D·V. Lift q·f(v)·(z x v)/|v| with f = w·v²/(2w + v), w = R·|omega|:
// f' = w·v·(4w + v)/(2w + v)² <= v and f/v <= v/2, so l = q·V. Gravity has none. L is the sum of these.
//
// Spin. omega = omega0·exp(∓c·s), s the way flown. To first order the equator turns by -omega0·c·v0·t²/2
// more; off it |Domega| <= |omega0|·(exp(c·V·t) - 1 - c·V·t + c·A·t²/2), convex, hence that·t/3. Lift changes
// by at most q·V³/(2w + V)²·R·|omega0|·(exp(c·V·t) - 1), w the least on the leg, growing convexly from 0, so
// that the place moves by at most that·t²/6 (counted with spin decay; with lift, whose w may be larger by
// the same factor, likewise). And what changes the speed changes the way flown, by at most
// a_max·exp(L·t)·t²/2, hence the spin by |omega|·c of that and the equator by |omega|·c·a_max·exp(L·t)·t³/6.
//
// All this holds whichever of the other effects are there, so that what several do adds up.
#pragma once

#include "sim/plan/displacement.hpp"
#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// A leg's motion at the surface.
struct LegMotion {
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double omega_radps = 0.0;
};

class FlightBounds {
 public:
  explicit FlightBounds(const Scene& scene);

  /// For gravity, drag, magnus and spin_decay; zero for other effects. `time_s` >= 0: how far from
  /// touchdown or lift-off. `within` is infinite where no bound exists.
  BoundedDisplacement of(Effect effect, const LegMotion& leg, double time_s) const;

  /// The larger of the shares of the velocity that drag and lift change in a metre.
  double largest_coefficient_pm() const { return drag_pm_ > lift_pm_ ? drag_pm_ : lift_pm_; }

 private:
  struct Leg;
  Leg leg_of(const LegMotion& motion, double time_s) const;
  BoundedDisplacement displaced(const Leg& leg, double ax_mps2, double ay_mps2, double lipschitz_ps) const;
  BoundedDisplacement by_spin_decay(const Leg& leg) const;

  double gravity_x_mps2_;
  double gravity_y_mps2_;
  double air_pm_;   ///< q
  double drag_pm_;  ///< q·C_D
  double lift_pm_;  ///< q, or 0 without lift
  double decay_pm_;
  double radius_m_;
};

}  // namespace strobe::sim
