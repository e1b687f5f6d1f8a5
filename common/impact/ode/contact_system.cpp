#include "common/impact/ode/contact_system.hpp"

#include <algorithm>
#include <cassert>

#include "common/impact/ode/normal_spring.hpp"

namespace strobe::impact::detail {

namespace {

bool within(double value, double low, double high) { return value >= low && value <= high; }

bool all_finite(const ball::Ball& b, const Motion& m, const ContactCoefficients& c) {
  for (const double v : {b.diameter_m, b.mass_kg, b.alpha, m.vx_mps, m.vy_mps, m.omega_radps, c.e, c.dwell_s,
                         c.mu, c.stiffness_ratio, c.damping_ratio, c.offset_share, c.offset_reference_mps,
                         c.gravity_mps2, c.gravity_along_mps2})
    if (!std::isfinite(v)) return false;
  return true;
}

std::optional<InputError> find_motion_error(const ball::Ball& b, const Motion& m) {
  if (b.diameter_m <= 0.0 || b.mass_kg <= 0.0 || b.alpha <= 0.0 || b.alpha > ball::kThinShellAlpha)
    return InputError::ball_out_of_range;
  if (m.vy_mps >= 0.0) return InputError::not_approaching;
  const double largest = 1e9;
  if (!within(b.diameter_m, 1e-9, largest) || !within(b.mass_kg, 1e-9, largest) || b.alpha < 1e-6 ||
      !within(-m.vy_mps, 1e-15, largest) || std::abs(m.vx_mps) > largest || std::abs(m.omega_radps) > largest)
    return InputError::magnitude_out_of_range;
  if (std::max(std::abs(m.vx_mps), std::abs(b.radius_m() * m.omega_radps)) > -1e15 * m.vy_mps)
    return InputError::magnitude_out_of_range;
  return std::nullopt;
}

std::optional<InputError> find_coefficient_error(const ContactCoefficients& c) {
  if (!within(c.e, 0.0, 1.0)) return InputError::restitution_out_of_range;
  if (c.dwell_s <= 0.0) return InputError::dwell_not_positive;
  if (c.mu < 0.0) return InputError::friction_negative;
  if (c.e < kMinSpringRestitution || !within(c.stiffness_ratio, 1e-3, 1e3) ||
      (c.damping_ratio != 0.0 && !within(c.damping_ratio, 0.01, 10.0)))
    return InputError::spring_out_of_range;
  if (!within(c.offset_share, 0.0, 1.0) || !within(c.offset_reference_mps, 1e-9, 1e9))
    return InputError::offset_out_of_range;
  if (!within(c.dwell_s, 1e-9, 1e3) || c.mu > 1e3 || !within(c.gravity_mps2, 0.0, 1e3) ||
      !within(c.gravity_along_mps2, -1e3, 1e3))
    return InputError::magnitude_out_of_range;
  return std::nullopt;
}

struct Term {
  const State* derivative;
  double weight;
};

template <std::size_t n>
State combine(const State& z, double h, const std::array<Term, n>& terms) {
  State out;
  for (std::size_t i = 0; i < kComponents; ++i) {
    double sum = 0.0;
    for (const Term& term : terms) sum += term.weight * (*term.derivative)[i];
    out[i] = z[i] + h * sum;
  }
  return out;
}

}  // namespace

double System::friction(const State& z, ContactMode mode) const {
  return mode == ContactMode::grips ? holding_force(z) : direction(mode) * mu * normal_force(z);
}

double System::offset(const State& z) const {
  if (delta == 0.0) return 0.0;
  const double share = std::clamp(z[kDepth] / radius, 0.0, 1.0);
  const double full = delta * std::sqrt(share * (2.0 - share));
  if (ahead != 0.0) return ahead * full;
  const double w = spin(z);
  return -full * w / std::sqrt(w * w + w_ref * w_ref);
}

double System::tangential_scale() const {
  constexpr double kMinMotion = 1e-200;  // of a motion that does not take place; its inverse is finite
  const double offset = delta > 0.0 ? 2.0 * delta * std::sqrt(std::min(1.0, 2.0 / radius)) : 0.0;
  const double pulled = std::abs(along) * release_phase;
  return std::max(std::min(2.0 * mu, std::abs(slip0) + pulled) + offset + pulled, kMinMotion);
}

tl::expected<System, InputError> make_system(const ball::Ball& ball, const Motion& touchdown,
                                             const ContactCoefficients& c) {
  if (!all_finite(ball, touchdown, c)) return tl::unexpected(InputError::not_finite);
  if (const auto error = find_motion_error(ball, touchdown)) return tl::unexpected(*error);
  if (const auto error = find_coefficient_error(c)) return tl::unexpected(*error);
  const auto spring = normal_spring(ball.mass_kg, c.e, c.dwell_s);
  if (!spring) return tl::unexpected(spring.error());
  const double speed = -touchdown.vy_mps;
  System s;
  s.zeta = spring->damping_ratio;
  s.release_phase = spring->release_phase;
  s.mu = c.mu;
  s.kt = c.stiffness_ratio;
  s.ct = c.damping_ratio * std::sqrt(c.stiffness_ratio);
  s.alpha = ball.alpha;
  s.delta = c.offset_share;
  if (c.offset_law == OffsetLaw::constant_ahead) s.ahead = std::copysign(1.0, touchdown.vx_mps);
  s.w_ref = c.offset_reference_mps / speed;
  s.radius = ball.radius_m() * (spring->frequency_radps / speed);
  s.gravity = c.gravity_mps2 / (spring->frequency_radps * speed);
  s.along = c.gravity_along_mps2 / (spring->frequency_radps * speed);
  s.vx0 = touchdown.vx_mps / speed;
  s.w0 = ball.radius_m() * touchdown.omega_radps / speed;
  // The slip may be the small difference of large numbers: one rounding only.
  s.slip0 = std::fma(ball.radius_m(), touchdown.omega_radps, touchdown.vx_mps) / speed;
  s.speed_mps = speed;
  s.frequency_radps = spring->frequency_radps;
  s.mass_kg = ball.mass_kg;
  s.radius_m = ball.radius_m();
  assert(s.zeta >= 0.0 && s.kt > 0.0 && s.radius > 0.0 && s.w_ref > 0.0 && std::isfinite(s.slip0));
  return s;
}

ContactLiftOff lift_off_of(const System& s, const State& z, double tau) {
  const double second = 1.0 / s.frequency_radps, metre = s.speed_mps * second;
  ContactLiftOff out;
  out.lift_off = {s.speed_mps * (s.vx0 + z[kVxChange]), -s.speed_mps * z[kDepthRate],
                  s.speed_mps * (s.w0 + z[kSpinChange]) / s.radius_m};
  out.dwell_s = tau * second;
  out.dwell_distance_m = metre * s.path(tau, z[kPathChange]);
  out.rotation_rad = metre * (s.w0 * tau + z[kAngleChange]) / s.radius_m;
  return out;
}

ContactEnergy energy_at_release(const System& s, const State& z, double tau) {
  const double unit = s.mass_kg * s.speed_mps * s.speed_mps;
  const double vy = z[kDepthRate], dx = z[kVxChange], dw = z[kSpinChange];
  const double lost =
      0.5 * (1.0 - vy) * (1.0 + vy) - dx * (s.vx0 + 0.5 * dx) - s.alpha * dw * (s.w0 + 0.5 * dw);
  ContactEnergy e;
  e.kinetic_td_j = unit * 0.5 * (s.vx0 * s.vx0 + 1.0 + s.alpha * s.w0 * s.w0);
  e.kinetic_lo_j = unit * 0.5 * ((s.vx0 + dx) * (s.vx0 + dx) + vy * vy + s.alpha * (s.w0 + dw) * (s.w0 + dw));
  e.kinetic_lost_j = unit * lost;
  e.normal_spring_left_j = unit * 0.5 * z[kDepth] * z[kDepth];
  e.tangential_spring_left_j = unit * 0.5 * s.kt * z[kStretch] * z[kStretch];
  e.gravity_work_j = unit * s.gravity * z[kDepth];
  if (s.along != 0.0) e.gravity_work_j += unit * s.along * s.path(tau, z[kPathChange]);
  return e;
}

void add_event(ContactSummary& summary, const ContactEvent& event) {
  using Kind = ContactEventKind;
  // The others come once each, but where rounding repeats a largest force.
  const bool often =
      event.kind == Kind::grip || event.kind == Kind::slip || event.kind == Kind::friction_reversal;
  const int reserved = often ? 4 : event.kind == Kind::release ? 0 : 1;
  if (summary.event_count >= kMaxContactEvents - reserved) {
    ++summary.events_left_out;
    return;
  }
  // What is noted within a step may come before what was noted first.
  auto place = summary.events.begin() + summary.event_count++;
  for (; place != summary.events.begin() && (place - 1)->time_s > event.time_s; --place)
    *place = *(place - 1);
  *place = event;
}

State derivative(const System& s, const State& z, ContactMode mode) {
  const double normal = s.normal_force(z);
  const double acceleration = s.gravity - normal;
  const double slip = s.slip(z);
  double friction = 0.0;
  double stretch_rate = slip;
  if (mode == ContactMode::grips) {
    friction = s.holding_force(z);
  } else {
    const double limit = direction(mode) * s.mu;
    friction = limit * normal;
    stretch_rate = s.ct > 0.0 ? (friction - s.kt * z[kStretch]) / s.ct
                              : limit * (z[kDepthRate] + 2.0 * s.zeta * acceleration) / s.kt;
  }
  const double couple = s.offset(z) * normal;
  State d;
  d[kDepth] = z[kDepthRate];
  d[kDepthRate] = acceleration;
  d[kVxChange] = s.along - friction;
  d[kSpinChange] = (couple - friction) / s.alpha;
  d[kStretch] = stretch_rate;
  d[kPathChange] = z[kVxChange];
  d[kAngleChange] = z[kSpinChange];
  d[kDampingLoss] = 2.0 * s.zeta * z[kDepthRate] * z[kDepthRate];
  d[kSlidingLoss] = friction * (slip - stretch_rate);
  d[kTangentialLoss] = s.ct * stretch_rate * stretch_rate;
  d[kOffsetLoss] = -couple * s.spin(z);
  d[kOffsetImpulse] = couple;
  return d;
}

ContactMode initial_mode(const System& s) {
  // With nothing stretched yet: by the dashpot's force, and where there is none by how fast the spring's
  // force and its limit rise.
  const double limit = s.mu * 2.0 * s.zeta;
  const double held = s.ct * std::abs(s.slip0);
  const double limit_rate = s.mu * (1.0 + 2.0 * s.zeta * (s.gravity - 2.0 * s.zeta));
  // A contact point at rest is pulled along by the weight.
  const double hold_rate = s.kt * s.slip0 + s.ct * s.along;
  const bool pulled = s.mu == 0.0 && s.slip0 == 0.0 && s.along != 0.0;
  if (held > limit) return slipping(s.slip0);
  if (held == limit && std::abs(hold_rate) > limit_rate) return slipping(hold_rate);
  return pulled ? slipping(s.along) : ContactMode::grips;
}

State take_step(const System& s, ContactMode mode, const State& z, const State& k1, double h) {
  State error;
  return take_step_with_error(s, mode, z, k1, h, error);
}

State take_step_with_error(const System& s, ContactMode mode, const State& z, const State& k1, double h,
                           State& error) {
  const State k2 = derivative(s, combine<1>(z, h, {{{&k1, 1.0 / 5.0}}}), mode);
  const State k3 = derivative(s, combine<2>(z, h, {{{&k1, 3.0 / 40.0}, {&k2, 9.0 / 40.0}}}), mode);
  const State k4 =
      derivative(s, combine<3>(z, h, {{{&k1, 44.0 / 45.0}, {&k2, -56.0 / 15.0}, {&k3, 32.0 / 9.0}}}), mode);
  const State k5 = derivative(s,
                              combine<4>(z, h,
                                         {{{&k1, 19372.0 / 6561.0},
                                           {&k2, -25360.0 / 2187.0},
                                           {&k3, 64448.0 / 6561.0},
                                           {&k4, -212.0 / 729.0}}}),
                              mode);
  const State k6 = derivative(s,
                              combine<5>(z, h,
                                         {{{&k1, 9017.0 / 3168.0},
                                           {&k2, -355.0 / 33.0},
                                           {&k3, 46732.0 / 5247.0},
                                           {&k4, 49.0 / 176.0},
                                           {&k5, -5103.0 / 18656.0}}}),
                              mode);
  const State out = combine<5>(z, h,
                               {{{&k1, 35.0 / 384.0},
                                 {&k3, 500.0 / 1113.0},
                                 {&k4, 125.0 / 192.0},
                                 {&k5, -2187.0 / 6784.0},
                                 {&k6, 11.0 / 84.0}}});
  const State k7 = derivative(s, out, mode);
  const State zero{};
  error = combine<6>(zero, h,
                     {{{&k1, 71.0 / 57600.0},
                       {&k3, -71.0 / 16695.0},
                       {&k4, 71.0 / 1920.0},
                       {&k5, -17253.0 / 339200.0},
                       {&k6, 22.0 / 525.0},
                       {&k7, -1.0 / 40.0}}});
  return out;
}

}  // namespace strobe::impact::detail
