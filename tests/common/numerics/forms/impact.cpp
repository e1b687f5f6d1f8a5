// In/out models. The reference solves the impulse equations as a linear system and bisects the energy.
#include <algorithm>
#include <array>

#include "common/impact/closed_form/rebound.hpp"
#include "tests/common/numerics/forms/forms.hpp"
#include "tests/common/numerics/forms/wide.hpp"

namespace strobe::numerics {

namespace {

using impact::Coefficients;
using impact::Motion;
using impact::Rebound;

/// The arguments of an impact as wide numbers, so that they can be varied by less than a double can.
struct WideInput {
  Wide radius, alpha, vx, vy, omega, e, mu, e_x, offset, reference;
  static constexpr std::size_t kCount = 10;
  Wide& at(std::size_t i) {
    const std::array<Wide*, kCount> all{&radius, &alpha, &vx,  &vy,     &omega,
                                        &e,      &mu,    &e_x, &offset, &reference};
    return *all[i];
  }
};

struct WideRebound {
  Wide vx, omega, slip, ratio, offset;
  Wide dvx_scale;           ///< size of the terms that the change of vx is made of
  bool near_limit = false;  ///< the regime is open within 1e-13
  bool grips = false;
  bool limited = false;  ///< the offset was lessened
  static constexpr std::size_t kCount = 5;
  const Wide& at(std::size_t i) const {
    const std::array<const Wide*, kCount> all{&vx, &omega, &slip, &ratio, &offset};
    return *all[i];
  }
};

/// Impulses per mass P (along x) and the lift-off they lead to, for a normal force at a distance d:
///   vx' - vx - P = 0,  alpha·R²·(omega' - omega) - R·P = d·J,  gripping: vx' + R·omega' = -e_x·(vx +
///   R·omega).
struct Solution {
  Wide vx, omega, friction;
  bool grips;
};

Solution solve(const WideInput& in, const Wide& d, const Wide& impulse) {
  const Wide slip = in.vx + in.radius * in.omega;
  // Elimination of vx' and omega' from the third equation leaves one for P.
  const Wide inertia = in.alpha * in.radius * in.radius;
  const Wide coefficient = 1 + in.radius * in.radius / inertia;
  const Wide right = -in.e_x * slip - slip - in.radius * d * impulse / inertia;
  Wide p = right / coefficient;
  const Wide limit = in.mu * impulse;
  const bool grips = abs(p) <= limit;
  if (!grips) p = p > 0 ? limit : Wide(-limit);
  return {in.vx + p, in.omega + (in.radius * p + d * impulse) / inertia, p, grips};
}

Wide energy(const WideInput& in, const Wide& vx, const Wide& omega) {
  return vx * vx + in.alpha * in.radius * in.radius * omega * omega;
}

WideRebound reference(const WideInput& in) {
  const Wide impulse = (1 + in.e) * -in.vy, rolling = (in.vx - in.radius * in.omega) / 2;
  const Wide d = in.offset * rolling / sqrt(rolling * rolling + in.reference * in.reference);
  const Solution without = solve(in, 0, impulse);
  const Solution with = solve(in, d, impulse);
  const Wide before = energy(in, in.vx, in.omega);
  const auto gain = [&](const Wide& share) {
    return Wide(energy(in, without.vx + share * (with.vx - without.vx),
                       without.omega + share * (with.omega - without.omega)) -
                before);
  };
  Wide share = 1;
  if (d != 0 && gain(1) > 0) {
    // The parabola through its values at 0, 1/2 and 1.
    const Wide c = gain(0), half = gain(Wide(1) / 2), one = gain(1);
    const Wide a = 2 * (one - 2 * half + c), b = one - c - a;
    share = (-b + sqrt(abs(b * b - 4 * a * c))) / (2 * a);
  }
  WideRebound out;
  out.limited = share < 1;
  out.vx = without.vx + share * (with.vx - without.vx);
  out.omega = without.omega + share * (with.omega - without.omega);
  out.slip = out.vx + in.radius * out.omega;
  out.ratio = (in.vx - out.vx) / impulse;
  out.offset = share * d;
  out.grips = out.limited ? without.grips : with.grips;
  const Wide slip = in.vx + in.radius * in.omega;
  const Wide needed = (abs((1 + in.e_x) * slip) * in.alpha + abs(d) * impulse / in.radius) / (1 + in.alpha);
  const Wide limit = in.mu * impulse;
  out.near_limit = abs(abs(needed) - limit) < 1e-13 * needed || abs(share - 1) < 1e-13 ||
                   abs(with.friction) > limit * (1 - Wide(1e-12));
  out.dvx_scale = needed < limit ? needed : limit;
  return out;
}

WideInput widened(const ball::Ball& ball, const Motion& m, const Coefficients& c) {
  return {
      Wide(ball.diameter_m) / 2, ball.alpha, m.vx_mps, m.vy_mps, m.omega_radps, c.e, c.mu, c.e_x, c.offset_m,
      c.offset_reference_mps};
}

/// What the model's formulas give when written down as they are read.
struct Textbook {
  double vx, omega, slip, ratio;
};

Textbook textbook(const ball::Ball& ball, const Motion& m, const Coefficients& c) {
  const double radius = ball.radius_m(), slip = m.vx_mps + radius * m.omega_radps;
  const double impulse = (1.0 + c.e) * -m.vy_mps;
  const double rolling = 0.5 * (m.vx_mps - radius * m.omega_radps);
  const double d =
      c.offset_m * rolling / std::sqrt(rolling * rolling + c.offset_reference_mps * c.offset_reference_mps);
  const double needed =
      -((1.0 + c.e_x) * slip + d * impulse / (ball.alpha * radius)) / (1.0 + 1.0 / ball.alpha);
  const double dvx = std::clamp(needed, -c.mu * impulse, c.mu * impulse);
  const double vx = m.vx_mps + dvx;
  const double omega = m.omega_radps + (radius * dvx + d * impulse) / (ball.alpha * radius * radius);
  return {vx, omega, vx + radius * omega, (m.vx_mps - vx) / impulse};
}

void compare_impact(const ball::Ball& ball, const Motion& m, const Coefficients& c, Tally& tally) {
  const Rebound got = *impact::grip(ball, m, c);
  const WideInput in = widened(ball, m, c);
  const WideRebound want = reference(in);
  const Textbook plain = textbook(ball, m, c);
  const double outputs[] = {got.lift_off.vx_mps, got.lift_off.omega_radps, got.slip_lo_mps, got.impulse_ratio,
                            got.offset_m};
  const char* const names[] = {"vx_lo", "omega_lo", "slip_lo", "impulse_ratio", "offset"};
  const Wide impulse = (1 + in.e) * -in.vy, push = abs(want.offset) * impulse / in.radius;
  const Wide dspin_scale = (want.dvx_scale + push) / in.alpha;
  Wide scales[] = {abs(in.vx) + want.dvx_scale, abs(in.omega) + dspin_scale / in.radius,
                   abs(in.vx + in.radius * in.omega) + want.dvx_scale + dspin_scale, want.dvx_scale / impulse,
                   0};
  if (want.limited) {
    // Where the energy lessens the offset, a square root may magnify any rounding: the scale grows to what a
    // relative change of 1e-13 of each argument does.
    for (std::size_t i = 0; i < WideInput::kCount; ++i) {
      WideInput varied = in;
      varied.at(i) *= 1 + Wide(1e-13);
      const WideRebound other = reference(varied);
      for (std::size_t k = 0; k < WideRebound::kCount; ++k)
        scales[k] += abs(other.at(k) - want.at(k)) * Wide(1e13);
    }
  }
  for (std::size_t k = 0; k < WideRebound::kCount; ++k) {
    const std::optional<double> book =
        want.limited || k == 4 ? std::nullopt
                               : std::optional(std::array{plain.vx, plain.omega, plain.slip, plain.ratio}[k]);
    compare(tally, names[k], outputs[k], book, want.at(k), scales[k]);
  }
  compare(tally, "vy_lo", got.lift_off.vy_mps, {}, in.e * -in.vy, 0);
  const bool as_computed = (got.regime == Regime::grips) == want.grips;
  tally.record("regime", as_computed || want.near_limit ? 0.0 : 1.0, 0.0, {});
}

/// Speed and angle of incidence; a right angle has no component along the surface.
Motion touchdown(double speed, double angle_deg, double omega) {
  const double angle = angle_deg / 180.0 * 3.14159265358979323846;
  return {angle_deg == 90.0 ? 0.0 : speed * std::cos(angle), -speed * std::sin(angle), omega};
}

void rigid_body(std::span<const double> x, Tally& tally) {
  compare_impact({.diameter_m = x[5], .alpha = x[6]}, touchdown(x[0], x[1], x[2]), {.e = x[3], .mu = x[4]},
                 tally);
}

/// Spins within a part in 1e16…1 of rolling, on either side of it.
void nearly_rolling(std::span<const double> x, Tally& tally) {
  Motion m = touchdown(x[0], x[1], 0.0);
  const ball::Ball ball{.diameter_m = x[5], .alpha = x[6]};
  m.omega_radps = -m.vx_mps / ball.radius_m() * (1.0 + x[2]);
  compare_impact(ball, m, {.e = x[3], .mu = x[4]}, tally);
}

void with_offset(std::span<const double> x, Tally& tally) {
  const ball::Ball ball{.diameter_m = x[5], .alpha = x[6]};
  const Coefficients c{
      .e = x[3], .mu = x[4], .e_x = x[7], .offset_m = x[8] * ball.radius_m(), .offset_reference_mps = x[9]};
  compare_impact(ball, touchdown(x[0], x[1], x[2]), c, tally);
}

std::vector<Axis> axes(Axis spin) {
  return {logarithmic("speed_mps", 1e-6, 1e3),
          logarithmic("angle_deg", 0.01, 90.0),
          std::move(spin),
          unit_interval("e"),
          logarithmic("mu", 1e-6, 10.0, {0.0, 0.55, 0.4}),
          logarithmic("diameter_m", 1e-3, 1.0, {0.0651}),
          logarithmic("alpha", 0.01, 2.0 / 3.0, {0.55})};
}

}  // namespace

std::vector<Form> impact_forms() {
  const std::string scale = "the terms that the output is the sum of";
  const std::vector<Axis> any_spin = axes(either_sign("omega_radps", 1e-3, 1e5));
  const std::vector<Axis> rolling = axes(either_sign("excess", 1e-16, 1.0));
  std::vector<Axis> offset = any_spin;
  offset.push_back(even("ex", -1.0, 1.0, {0.0, 0.087, 1.0 - 1e-12, -1.0 + 1e-12}));
  offset.push_back(logarithmic("offset/radius", 1e-12, 0.99, {0.0, 0.09}));
  offset.push_back(logarithmic("reference_mps", 1e-3, 100.0, {2.5}));
  return {
      {"rigid", scale, "slip by one rounding (fma), lift-off slip from it rather than from the speeds",
       any_spin, rigid_body},
      {"rigid, nearly rolling", scale,
       "slip by one rounding (fma), lift-off slip from it rather than from the speeds", rolling,
       nearly_rolling},
      {"grip with e_x and offset", scale + "; under the energy limit what 1e-13 of an argument changes",
       "offset's step and powers written out, the root by the form without cancellation", offset,
       with_offset},
  };
}

}  // namespace strobe::numerics
