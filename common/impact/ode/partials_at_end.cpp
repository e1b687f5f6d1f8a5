// segment_partials.hpp: from the sums over a segment's nodes to the derivatives at its end, and across an event.
#include "common/impact/ode/free_grip.hpp"
#include "common/impact/ode/friction_law.hpp"
#include "common/impact/ode/segment_partials.hpp"

namespace strobe::impact::detail {

namespace {

/// The share of the friction's limit that the stretch of a long slip comes to, and its derivatives with respect to zeta
/// and to i = c_t/k_t: depth·(y - g) + rate·y' + g.
struct ParticularStretch {
  double depth, rate, depth_by_zeta, rate_by_zeta, depth_by_i, rate_by_i;

  ParticularStretch(double zeta, double i) {
    const double rest = 1.0 + i * (i - 2.0 * zeta), excess = 2.0 * zeta - i;
    rate = excess / rest;
    depth = 1.0 + rate * i;
    rate_by_zeta = (2.0 + 2.0 * i * rate) / rest;
    rate_by_i = -(1.0 + rate * (2.0 * i - 2.0 * zeta)) / rest;
    depth_by_zeta = i * rate_by_zeta;
    depth_by_i = rate + i * rate_by_i;
  }
};

}  // namespace

/// s = slip0 + beta·P + D/alpha + g_x·t at all times.
Partials VariationalEquations::slip_of(const TangentialPartials& at, double tau, double spin) const {
  Partials slip{};
  add(slip, at.friction, c_.beta);
  add(slip, at.couple, 1.0 / s_.alpha);
  slip[kBySlip] += 1.0;
  slip[kByAlong] += tau;
  slip[kByAlpha] -= (spin - s_.w0) / s_.alpha;
  return slip;
}

Partials VariationalEquations::slipping_stretch(const NormalState& normal, const NormalPartials& by,
                                                double sign) const {
  const double i = s_.ct / s_.kt, g = s_.gravity, per_kt = sign / s_.kt, limit = s_.mu * per_kt;
  const ParticularStretch p(s_.zeta, i);
  const double share = g + (p.depth * (normal.depth - g) + p.rate * normal.rate);
  const double by_i = p.depth_by_i * (normal.depth - g) + p.rate_by_i * normal.rate;
  Partials out{};
  out[kByMu] = per_kt * share;
  out[kByKt] = -limit / s_.kt * (share + by_i * i);
  out[kByCt] = limit * by_i / s_.kt;
  out[kByZeta] = limit * (p.depth * by.zeta.depth + p.rate * by.zeta.rate +
                          p.depth_by_zeta * (normal.depth - g) + p.rate_by_zeta * normal.rate);
  out[kByGravity] = limit * (1.0 + p.depth * (by.gravity.depth - 1.0) + p.rate * by.gravity.rate);
  return out;
}

void VariationalEquations::finish_slip(const Segment& segment) {
  const SegmentPoint& end = segment.end;
  const double sign = direction(segment.mode), limit = sign * s_.mu;
  const double elapsed = end.normal.tau - segment.from.tau;
  const NormalPartials from = normal_partials(s_, segment.from), to = normal_partials(s_, end.normal);
  const double impulse = c_.normal.impulse(segment.from);
  const auto integral_of = [&](const NormalPartial& a, const NormalPartial& b) {
    return b.impulse_integral - a.impulse_integral - a.impulse * elapsed;
  };
  add(at_.path, at_.friction, elapsed);
  at_.path[kByMu] -= sign * (c_.normal.impulse_integral(end.normal) -
                             c_.normal.impulse_integral(segment.from) - impulse * elapsed);
  at_.path[kByZeta] -= limit * integral_of(from.zeta, to.zeta);
  at_.path[kByGravity] -= limit * integral_of(from.gravity, to.gravity);
  add(at_.couple_integral, at_.couple, elapsed);
  add(at_.couple_integral, ends_[kOverTime], 1.0);
  at_.friction[kByMu] -= sign * (c_.normal.impulse(end.normal) - impulse);
  at_.friction[kByZeta] -= limit * (to.zeta.impulse - from.zeta.impulse);
  at_.friction[kByGravity] -= limit * (to.gravity.impulse - from.gravity.impulse);
  add(at_.couple, ends_[kImpulse], 1.0);

  Partials stretch = slipping_stretch(end.normal, to, sign);
  if (s_.ct > 0.0) {
    const double fade = std::exp(-c_.kappa * elapsed);
    const double transient = segment.start.stretch - c_.slipping_stretch(segment.from, sign);
    add(stretch, at_.stretch, fade);
    add(stretch, slipping_stretch(segment.from, from, sign), -fade);
    stretch[kByKt] -= elapsed * fade * transient / s_.ct;
    stretch[kByCt] += elapsed * fade * transient * c_.kappa / s_.ct;
  }
  at_.stretch = stretch;
}

void VariationalEquations::finish_grip(const Segment& segment, const GripStart& start) {
  const SegmentPoint& end = segment.end;
  const double per_alpha = 1.0 / s_.alpha, per_beta = 1.0 / c_.beta;
  const double tau = end.normal.tau, elapsed = tau - segment.from.tau;
  Partials first = start.first, second = start.second, integral = ends_[kOverTime];
  add(integral, at_.couple, elapsed);
  add(second, ends_[kCosine], per_alpha);
  add(first, ends_[kSine], -per_alpha);
  for (std::size_t i = 0; i < nodes_; ++i) {
    const double cosine = weight_[i] * to_cosine_[i], sine = weight_[i] * to_sine_[i];
    second[kByAlpha] += cosine * forcing_[i].alpha;
    second[kByKt] += cosine * forcing_[i].kt;
    second[kByCt] += cosine * forcing_[i].ct;
    first[kByAlpha] -= sine * forcing_[i].alpha;
    first[kByKt] -= sine * forcing_[i].kt;
    first[kByCt] -= sine * forcing_[i].ct;
  }
  add(at_.couple, ends_[kImpulse], 1.0);
  const Oscillation o = oscillation(c_.omega2, elapsed);
  const double fade = std::exp(-c_.b * elapsed);
  const FreeGrip free(c_, segment.start, elapsed, o, fade);
  Partials stretch = start.rest, slip{};
  add(stretch, first, fade * o.cosine);
  add(stretch, second, fade * o.sine);
  add(stretch, start.b, free.stretch_by_b);
  add(stretch, start.omega2, free.stretch_by_omega2);
  add(slip, second, fade * (o.cosine - c_.b * o.sine));
  add(slip, first, -fade * (c_.b * o.cosine + c_.omega2 * o.sine));
  add(slip, start.b, free.slip_by_b);
  add(slip, start.omega2, free.slip_by_omega2);

  // The integral of the slip is the stretch.
  add(at_.path, stretch, per_beta);
  add(at_.path, at_.stretch, -per_beta);
  add(at_.path, integral, -per_alpha * per_beta);
  at_.path[kBySlip] -= per_beta * elapsed;
  at_.path[kByAlong] -= per_beta * 0.5 * (tau + segment.from.tau) * elapsed;
  at_.path[kByAlpha] += per_beta * per_alpha * (end.tangential.angle - segment.start.angle);
  add(at_.couple_integral, integral, 1.0);

  at_.friction.fill(0.0);
  add(at_.friction, slip, per_beta);
  add(at_.friction, at_.couple, -per_alpha * per_beta);
  at_.friction[kBySlip] -= per_beta;
  at_.friction[kByAlong] -= per_beta * tau;
  at_.friction[kByAlpha] += per_beta * (c_.spin(end.tangential) - s_.w0) * per_alpha;
  at_.stretch = stretch;
}

VariationalEquations::GripStart VariationalEquations::start_of_grip(const Segment& segment) const {
  const double beta_by_alpha = -1.0 / (s_.alpha * s_.alpha);
  GripStart out;
  out.b[kByCt] = 0.5 * c_.beta;
  out.b[kByAlpha] = 0.5 * s_.ct * beta_by_alpha;
  out.omega2[kByKt] = c_.beta;
  out.omega2[kByAlpha] = s_.kt * beta_by_alpha;
  add(out.omega2, out.b, -2.0 * c_.b);
  out.rest[kByAlong] = 1.0 / (c_.beta * s_.kt);
  out.rest[kByKt] = -c_.rest / s_.kt;
  out.rest[kByAlpha] = -c_.rest * beta_by_alpha / c_.beta;
  out.first = at_.stretch;
  add(out.first, out.rest, -1.0);
  // That with the rate b of the decay is the free grip's own.
  out.second = slip_of(at_, segment.from.tau, c_.spin(segment.start));
  add(out.second, out.first, c_.b);
  return out;
}

Partials VariationalEquations::friction_of(ContactMode mode, const SegmentPoint& end,
                                           const NormalPartials& by) const {
  Partials out{};
  if (mode == ContactMode::grips) {
    add(out, at_.stretch, s_.kt);
    add(out, slip_of(at_, end.normal.tau, c_.spin(end.tangential)), s_.ct);
    out[kByKt] += end.tangential.stretch;
    out[kByCt] += end.tangential.slip;
    return out;
  }
  const double sign = direction(mode);
  out[kByMu] = sign * c_.normal.force(end.normal);
  out[kByZeta] = sign * s_.mu * by.zeta.force;
  out[kByGravity] = sign * s_.mu * by.gravity.force;
  return out;
}

Partials VariationalEquations::stretch_rate_of(ContactMode mode, const SegmentPoint& end,
                                               const NormalPartials& by, const Partials& friction) const {
  if (mode == ContactMode::grips) return slip_of(at_, end.normal.tau, c_.spin(end.tangential));
  const double sign = direction(mode), force = c_.normal.force(end.normal);
  Partials out{};
  if (s_.ct > 0.0) {
    const double rate = (sign * s_.mu * force - s_.kt * end.tangential.stretch) / s_.ct;
    add(out, friction, 1.0 / s_.ct);
    add(out, at_.stretch, -c_.kappa);
    out[kByKt] -= end.tangential.stretch / s_.ct;
    out[kByCt] -= rate / s_.ct;
    return out;
  }
  const double limit = sign * s_.mu / s_.kt, rate = c_.normal.force_rate(end.normal);
  out[kByMu] = sign * rate / s_.kt;
  out[kByKt] = -limit * rate / s_.kt;
  out[kByCt] = -limit * ((s_.gravity - force) - 2.0 * s_.zeta * rate) / s_.kt;
  out[kByZeta] = limit * by.zeta.force_rate;
  out[kByGravity] = limit * by.gravity.force_rate;
  return out;
}

void VariationalEquations::change_law(const Segment& segment, ContactMode next) {
  const SegmentPoint& end = segment.end;
  const FrictionLaw law(c_, segment.mode);
  const double rate = law.rate(end);
  if (!(rate < 0.0)) return;
  const double late = law.value(end) / rate;
  const NormalPartials by = normal_partials(s_, end.normal);
  const Partials old_friction = friction_of(segment.mode, end, by), friction = friction_of(next, end, by);
  const Partials old_rate = stretch_rate_of(segment.mode, end, by, old_friction);
  const Partials stretch_rate = stretch_rate_of(next, end, by, friction);
  add(at_.friction, friction, -late);
  add(at_.friction, old_friction, late);
  add(at_.stretch, stretch_rate, late);
  add(at_.stretch, old_rate, -late);
}

}  // namespace strobe::impact::detail
