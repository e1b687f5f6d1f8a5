#include <algorithm>

#include "common/impact/closed_form/sine_pulse.hpp"
#include "common/units/angles.hpp"
#include "tests/common/numerics/forms/forms.hpp"
#include "tests/common/numerics/forms/wide_pulse.hpp"

namespace strobe::numerics {

namespace {

using impact::PulseForm;
using impact::SinePulse;

struct Plain {
  double first, second;
};

/// The integrals as the textbook writes them.
Plain textbook_integrals(double f, double theta) {
  const double decay = std::exp(-f * theta), s = std::sin(theta), c = std::cos(theta), q = 1.0 + f * f;
  return {(1.0 - decay * (f * s + c)) / q,
          theta / q - (decay * ((1.0 - f * f) * s - 2.0 * f * c) + 2.0 * f) / (q * q)};
}

void integrals(std::span<const double> x, Tally& tally) {
  const double f = x[0], theta = std::min(x[1], 3.14159265358979311600);
  const auto phase = impact::PulsePhase::at_angle(f, theta);
  const WideIntegrals want = taylor_integrals(f, theta);
  const Plain plain = textbook_integrals(f, theta);
  compare(tally, "I1", impact::impulse_integral(f, phase), plain.first, want.first, 0);
  compare(tally, "I2", impact::displacement_integral(f, phase), plain.second, want.second, 0);
  compare(tally, "theta - I2", impact::depth_integral(f, phase), theta - plain.second,
          Wide(theta) - want.second, 0);
}

/// Newton on e = (1 + exp(-f·pi))/(1 + f²) - 1 as it is written.
double textbook_damping(double e) {
  double f = 0.0;
  for (int i = 0; i < 60; ++i) {
    const double decay = std::exp(-f * kPi), q = 1.0 + f * f;
    f -= ((1.0 + decay) / q - 1.0 - e) / (-kPi * decay / q - 2.0 * f * (1.0 + decay) / (q * q));
  }
  return f;
}

void damping(std::span<const double> x, Tally& tally) {
  const double e = x[0];
  const double f = *impact::damping_from_restitution(PulseForm::exact, e);
  compare(tally, "exact", f, textbook_damping(e), WidePulse::of_restitution(PulseForm::exact, e, f).damping(),
          0);
  if (e == 0.0) return;
  compare(tally, "simplified", *impact::damping_from_restitution(PulseForm::simplified, e), {},
          WidePulse::of_restitution(PulseForm::simplified, e, 0.0).damping(), 0);
}

/// sin and cos of pi·tau with zeros where they belong.
Wide sine_at(double tau) { return tau > 0.5 ? sin(wide_pi() * (1 - Wide(tau))) : sin(wide_pi() * tau); }
Wide cosine_at(double tau) { return sin(wide_pi() * (Wide(0.5) - Wide(tau))); }

void state(PulseForm form, std::span<const double> x, Tally& tally) {
  const impact::PulseInput in{x[0], -x[1], x[2], x[3], x[4], 0.0576};
  const double tau = x[5];
  const SinePulse pulse = *SinePulse::make(form, in);
  const impact::PulseState got = pulse.at_fraction(tau);
  const WidePulse wide = WidePulse::of_restitution(form, in.e, pulse.damping());
  const bool exact = form == PulseForm::exact;

  const Wide f = wide.damping(), theta = wide_pi() * tau, speed = x[1], t = Wide(tau) * in.dwell_s;
  const Wide decay = exp(-f * theta), length = speed * in.dwell_s / wide_pi();
  const Wide impulse = exact ? wide.impulse(theta) : Wide(1 - decay * cosine_at(tau));
  const Wide path = wide.path(theta), ratio = in.impulse_ratio, vx = in.vx_td_mps;
  const Wide force = Wide(in.mass_kg) * speed * (wide_pi() / in.dwell_s) * decay * sine_at(tau);
  const Wide depth = exact ? Wide(theta - path) : Wide(decay * sine_at(tau));

  const double angle = kPi * tau, plain_speed = x[1], plain_length = plain_speed * in.dwell_s / kPi;
  const double plain_decay = std::exp(-pulse.damping() * angle);
  const Plain plain = exact
                          ? textbook_integrals(pulse.damping(), angle)
                          : Plain{1.0 - plain_decay * std::cos(angle), angle - plain_decay * std::sin(angle)};
  compare(tally, "vx", got.vx_mps, in.vx_td_mps - in.impulse_ratio * plain_speed * plain.first,
          vx - ratio * speed * impulse, abs(vx) + abs(ratio * speed * impulse));
  compare(tally, "vy", got.vy_mps, plain_speed * (plain.first - 1.0), speed * (impulse - 1), speed);
  compare(tally, "x", got.x_m,
          exact ? in.vx_td_mps * tau * in.dwell_s - in.impulse_ratio * plain_length * plain.second
                : (in.vx_td_mps - in.impulse_ratio * plain_speed) * tau * in.dwell_s +
                      in.impulse_ratio * plain_length * plain_decay * std::sin(angle),
          vx * t - ratio * length * path, abs(vx) * t + abs(ratio * length * path));
  compare(tally, "y", got.y_m, -plain_length * (angle - plain.second), -length * depth, length * Wide(1e-30));
  compare(tally, "fy", got.fy_n, in.mass_kg * plain_speed * kPi / in.dwell_s * plain_decay * std::sin(angle),
          force, 0);
  compare(tally, "fx", got.fx_n, {}, -ratio * force, 0);
  compare(tally, "impulse fraction", got.impulse_fraction, plain.first / (1.0 + in.e),
          impulse / (1 + Wide(in.e)), 0);
}

/// What a relative change of 1e-13 of the impulse asked for changes, besides the fraction itself: where the
/// force vanishes the inverse is a square root.
Wide fraction_scale(const WidePulse& wide, const Wide& target, const Wide& angle, double near) {
  const Wide varied = wide.angle_reaching(target * (1 - Wide(1e-13)), near);
  return (angle + abs(varied - angle) * Wide(1e13)) / wide_pi();
}

void fraction(PulseForm form, std::span<const double> x, Tally& tally) {
  const double e = x[0], share = x[1];
  const SinePulse pulse = *SinePulse::make(form, {1.0, -1.0, e, 0.5, 5e-3, 0.0576});
  const WidePulse wide = WidePulse::of_restitution(form, e, pulse.damping());
  const double got = pulse.fraction_at_impulse(share);
  const Wide target = Wide(share) * (1 + Wide(e));
  const Wide angle = wide.angle_reaching(target, got * kPi);
  compare(tally, "fraction", got, {}, angle / wide_pi(), fraction_scale(wide, target, angle, got * kPi));
}

void rebound(PulseForm form, std::span<const double> x, Tally& tally) {
  const double angle_rad = x[1] / 180.0 * kPi;
  const impact::Motion m{x[1] == 90.0 ? 0.0 : x[0] * std::cos(angle_rad), -x[0] * std::sin(angle_rad), x[2]};
  const double e = x[3], mu = x[4], dwell = x[5];
  const ball::Ball ball;
  const impact::PulseRebound got = *impact::pulse_rebound(form, ball, m, e, mu, dwell);
  const WidePulse wide = WidePulse::of_restitution(form, e, got.damping_f);
  const Wide speed = -Wide(m.vy_mps), length = speed * dwell / wide_pi(), f = wide.damping();

  const Wide peak = atan2(Wide(1), f);  // the force's derivative vanishes where tan(theta) = 1/f
  compare(tally, "largest force", got.max_force_n, {},
          Wide(ball.mass_kg) * speed * wide_pi() / dwell * exp(-f * peak) * sin(peak), 0);
  // vy vanishes where the exact impulse is 1; the simplified height is lowest at the force's peak.
  const Wide lowest = form == PulseForm::exact ? wide.angle_reaching(1, 1.5) : peak;
  compare(
      tally, "depth", got.depth_m, {},
      form == PulseForm::exact ? length * (lowest - wide.path(lowest)) : length * exp(-f * peak) * sin(peak),
      0);

  // The contact point stops when friction has taken s·alpha/(1 + alpha) from vx.
  const Wide slip = Wide(m.vx_mps) + Wide(ball.diameter_m) / 2 * m.omega_radps;
  const Wide needed = abs(slip) * ball.alpha / (1 + Wide(ball.alpha));
  const Wide most = Wide(mu) * (1 + Wide(e)) * speed;
  if (abs(needed - most) < needed * Wide(1e-12)) return;  // either regime
  Wide stop = wide_pi(), scale = 1;
  if (needed < most) {
    const Wide target = needed / (mu * speed);
    stop = wide.angle_reaching(target, got.grip_fraction * kPi);
    scale = fraction_scale(wide, target, stop, got.grip_fraction * kPi);
  }
  compare(tally, "grip fraction", got.grip_fraction, {}, stop / wide_pi(), scale);
  const Wide sign = slip < 0 ? -1 : slip > 0 ? 1 : 0, held = sign * mu * length * wide.path(stop);
  const Wide vx_lo = Wide(m.vx_mps) - sign * (needed < most ? needed : most);
  const Wide slides = Wide(m.vx_mps) * dwell * (stop / wide_pi());
  const Wide rolls = vx_lo * dwell * (1 - stop / wide_pi());
  // A moved grip instant changes the distance by the slip's share only; its own scale says by how much.
  const Wide vx_scale = (abs(Wide(m.vx_mps)) + needed) * dwell;
  compare(tally, "dwell distance", got.dwell_distance_m, {}, slides - held + rolls, vx_scale);
}

}  // namespace

std::vector<Form> pulse_forms() {
  std::vector<Form> forms{
      {"pulse integrals",
       "itself",
       "sums of terms of one sign, each with its own series near 0",
       {logarithmic("f", 1e-12, 10.0, {0.0, 0.046, 0.128, 0.4745, 1.0}),
        logarithmic("theta_rad", 1e-9, 3.14159265358979311600, {1.0, 1.5})},
       integrals},
      {"damping of e",
       "itself",
       "expm1 and 1 - e instead of the difference from e",
       {unit_interval("e")},
       damping},
  };
  for (const PulseForm form : {PulseForm::exact, PulseForm::simplified}) {
    const bool exact = form == PulseForm::exact;
    const std::string name = exact ? ", exact" : ", simplified";
    const double least_e = exact ? 0.0 : 1e-9;
    forms.push_back({"pulse state" + name,
                     "itself; vy: vy at touchdown; vx, x: the terms of the difference",
                     exact ? "integrals as above; sine from the nearer end"
                           : "expm1 and half angles; sine from the nearer end",
                     {either_sign("vx_mps", 1e-6, 1e3), logarithmic("vy_mps", 1e-6, 1e3),
                      unit_interval("e", least_e), either_sign("ratio", 1e-3, 10.0, {0.55}),
                      logarithmic("dwell_s", 1e-6, 1.0), unit_interval("time_fraction")},
                     [form](std::span<const double> x, Tally& tally) { state(form, x, tally); }});
    forms.push_back({"time of an impulse" + name,
                     "itself and what 1e-13 of the impulse changes",
                     "Halley's steps from a start of first order in f, in a bracket",
                     {unit_interval("e", least_e), unit_interval("fraction")},
                     [form](std::span<const double> x, Tally& tally) { fraction(form, x, tally); }});
    forms.push_back(
        {"rebound through the pulse" + name,
         "itself; grip: what 1e-13 of the impulse changes; distance: |vx|·dwell and what friction takes",
         "integrals as above",
         {logarithmic("speed_mps", 1e-6, 1e3), logarithmic("angle_deg", 0.01, 90.0),
          either_sign("omega_radps", 1e-3, 1e5), unit_interval("e", least_e),
          logarithmic("mu", 1e-6, 10.0, {0.55}), logarithmic("dwell_s", 1e-6, 1.0)},
         [form](std::span<const double> x, Tally& tally) { rebound(form, x, tally); }});
  }
  return forms;
}

}  // namespace strobe::numerics
