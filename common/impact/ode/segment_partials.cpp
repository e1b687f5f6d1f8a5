#include "common/impact/ode/segment_partials.hpp"

#include <cassert>
#include <utility>

#include "common/impact/ode/friction_law.hpp"

namespace strobe::impact::detail {

namespace {

void add(Partials& to, const Partials& what, double times) {
  for (std::size_t k = 0; k < kSystemInputs; ++k) to[k] += times * what[k];
}

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

/// A grip without couple about the stretch that holds the weight, exp(-b·t)·(first·C + second·S), and how it changes with
/// b and with omega2, its stretch at the start kept.
struct FreeGrip {
  double stretch, slip;
  double stretch_by_b, slip_by_b, stretch_by_omega2, slip_by_omega2;

  FreeGrip(const CollocationConstants& c, const TangentialState& start, double t, const Oscillation& o,
           double fade) {
    const double b = c.b, first = start.stretch - c.rest, second = start.slip + b * first;
    const double sine = fade * o.sine, cosine = fade * o.cosine;
    const double sine_by = -0.5 * fade * turned_sine(c.omega2, t, o), cosine_by = -0.5 * t * sine;
    stretch = first * cosine + second * sine;
    slip = second * (cosine - b * sine) - first * (b * cosine + c.omega2 * sine);
    stretch_by_b = first * sine - t * stretch;
    slip_by_b = -(first * b + second) * sine - t * slip;
    stretch_by_omega2 = first * cosine_by + second * sine_by;
    slip_by_omega2 = second * (cosine_by - b * sine_by) - first * (b * cosine_by + sine + c.omega2 * sine_by);
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

template <std::size_t n>
void VariationalEquations::use_rule(const Segment& segment) {
  constexpr const GaussLegendre<n>& rule = kGaussLegendre<n>;
  nodes_ = n;
  points_ = rule.points;
  node_ = rule.node.data();
  integral_ = rule.integral[0].data();
  if (segment.used == 1.0) {
    std::copy(rule.weight.begin(), rule.weight.end(), weight_.begin());
    return;
  }
  typename GaussLegendre<n>::Points weights;
  integral_weights<n>(segment.used, weights);
  std::copy_n(weights.begin(), n, weight_.begin());
}

void VariationalEquations::place_nodes(const Segment& segment) {
  switch (segment.nodes) {
    case 7:
      use_rule<7>(segment);
      break;
    case 9:
      use_rule<9>(segment);
      break;
    case 11:
      use_rule<11>(segment);
      break;
    case 12:
      use_rule<12>(segment);
      break;
    default:
      assert(segment.nodes == 13);
      use_rule<13>(segment);
  }
  for (std::size_t i = 0; i < nodes_; ++i) {
    const NodeSample& sample = segment.samples[i];
    const double x = segment.x + segment.size * node_[i];
    tau_[i] = c_.normal.tau(x);
    pace_[i] = segment.size * c_.normal.pace(x);
    const double rate = sample.force_rate - 2.0 * s_.zeta * (s_.gravity - sample.force);
    const NormalState normal{tau_[i], sample.force - 2.0 * s_.zeta * rate, rate};
    by_[i] = normal_partials(s_, normal);
    place_couple(i, sample, normal);
  }
}

/// The derivatives of G·h(w) with the spin kept, and that with respect to the spin.
void VariationalEquations::place_couple(std::size_t i, const NodeSample& sample, const NormalState& normal) {
  const double share = std::min(std::max(normal.depth / s_.radius, 0.0), 1.0);
  const double foot = std::sqrt(share * (2.0 - share));
  const double foot_by_share = share > 0.0 && share < 1.0 ? (1.0 - share) / foot : 0.0;
  const double w = sample.spin, norm = w * w + s_.w_ref * s_.w_ref;
  const double per_root = 1.0 / std::sqrt(norm);
  const bool turns = s_.ahead == 0.0;
  const double h = turns ? -w * per_root : s_.ahead;
  const double of_foot = pace_[i] * s_.delta * h * sample.force * foot_by_share / s_.radius;
  const double of_force = pace_[i] * s_.delta * h * foot;
  const double full = pace_[i] * s_.delta * foot * sample.force;
  const double bend = turns ? s_.w_ref * per_root * per_root * per_root : 0.0;
  Partials& row = rows_[i];
  row.fill(0.0);
  row[kByZeta] = of_foot * by_[i].zeta.depth + of_force * by_[i].zeta.force;
  row[kByGravity] = of_foot * by_[i].gravity.depth + of_force * by_[i].gravity.force;
  row[kByRadius] = -of_foot * share;
  row[kByDelta] = pace_[i] * foot * sample.force * h;
  row[kByReference] = full * w * bend;
  of_spin_[i] = -full * s_.w_ref * bend;
}

void VariationalEquations::place_slip(const Segment& segment) {
  const double limit = direction(segment.mode), per_alpha = 1.0 / s_.alpha;
  const double impulse = c_.normal.impulse(segment.from);
  const NormalPartials from = normal_partials(s_, segment.from);
  Partials base{};
  add(base, at_.couple, per_alpha);
  add(base, at_.friction, per_alpha);
  base[kBySpin] += 1.0;
  for (std::size_t i = 0; i < nodes_; ++i) {
    // Friction's impulse from the rate: J = g·tau + 1 - y'.
    const NodeSample& sample = segment.samples[i];
    const double rate = sample.force_rate - 2.0 * s_.zeta * (s_.gravity - sample.force);
    const double since = s_.gravity * tau_[i] + (1.0 - rate) - impulse;
    Partials spin = base;
    spin[kByMu] -= limit * since * per_alpha;
    spin[kByZeta] -= limit * s_.mu * (by_[i].zeta.impulse - from.zeta.impulse) * per_alpha;
    spin[kByGravity] -= limit * s_.mu * (by_[i].gravity.impulse - from.gravity.impulse) * per_alpha;
    spin[kByAlpha] -= (sample.spin - s_.w0) * per_alpha;
    add(rows_[i], spin, of_spin_[i]);
    for (std::size_t j = 0; j < nodes_; ++j)
      matrix_[i][j] = (i == j ? 1.0 : 0.0) - of_spin_[i] * per_alpha * integral(j, i);
  }
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

void VariationalEquations::place_grip(const Segment& segment) {
  const double alpha = s_.alpha, per_alpha = 1.0 / alpha, per_beta = 1.0 / c_.beta;
  const GripStart start = start_of_grip(segment);
  Nodes of_first, of_second, slip_by_b, slip_by_omega2;
  for (std::size_t i = 0; i < nodes_; ++i) {
    const double elapsed = tau_[i] - segment.from.tau;
    const Oscillation o = oscillation(c_.omega2, elapsed);
    const double fade = std::exp(-c_.b * elapsed);
    to_cosine_[i] = o.cosine / fade;
    to_sine_[i] = o.sine / fade;
    of_second[i] = fade * (o.cosine - c_.b * o.sine);
    of_first[i] = fade * (c_.b * o.cosine + c_.omega2 * o.sine);
    const NodeSample& sample = segment.samples[i];
    const FreeGrip free(c_, segment.start, elapsed, o, fade);
    slip_by_b[i] = free.slip_by_b;
    slip_by_omega2[i] = free.slip_by_omega2;
    // What the couple adds to the grip drives the derivatives in turn.
    const double stretch = sample.stretch - (c_.rest + free.stretch), slip = sample.slip - free.slip;
    const double friction = s_.kt * stretch + s_.ct * slip;
    forcing_[i] = {pace_[i] * (friction - sample.couple_rate) * per_alpha * per_alpha,
                   -pace_[i] * c_.beta * stretch, -pace_[i] * c_.beta * slip};
  }
  for (std::size_t i = 0; i < nodes_; ++i) {
    Partials slip{};
    add(slip, start.second, of_second[i]);
    add(slip, start.first, -of_first[i]);
    add(slip, start.b, slip_by_b[i]);
    add(slip, start.omega2, slip_by_omega2[i]);
    for (std::size_t j = 0; j < nodes_; ++j) {
      const double green = integral(j, i) * (of_second[i] * to_cosine_[j] + of_first[i] * to_sine_[j]);
      slip[kByAlpha] += green * forcing_[j].alpha;
      slip[kByKt] += green * forcing_[j].kt;
      slip[kByCt] += green * forcing_[j].ct;
      matrix_[i][j] =
          (i == j ? 1.0 : 0.0) - of_spin_[i] * per_alpha * per_beta * (integral(j, i) + per_alpha * green);
    }
    const double turned = (segment.samples[i].spin - s_.w0) * per_alpha;
    // alpha·dw = D + P, and beta·P follows from the slip.
    Partials spin{};
    add(spin, slip, per_alpha * per_beta);
    add(spin, at_.couple, per_alpha * per_beta);
    spin[kBySlip] -= per_alpha * per_beta;
    spin[kByAlong] -= per_alpha * per_beta * tau_[i];
    spin[kByAlpha] += turned * (per_alpha * per_beta - 1.0);
    spin[kBySpin] += 1.0;
    add(rows_[i], spin, of_spin_[i]);
  }
}

/// Gauss's elimination with the largest pivot.
void VariationalEquations::solve() {
  if (s_.delta == 0.0) return;
  const std::size_t n = nodes_;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::abs(matrix_[i][k]) > std::abs(matrix_[pivot][k])) pivot = i;
    if (pivot != k) {
      std::swap(matrix_[k], matrix_[pivot]);
      std::swap(rows_[k], rows_[pivot]);
    }
    const double inverse = 1.0 / matrix_[k][k];
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = matrix_[i][k] * inverse;
      for (std::size_t j = k + 1; j < n; ++j) matrix_[i][j] -= factor * matrix_[k][j];
      add(rows_[i], rows_[k], -factor);
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) add(rows_[k], rows_[j], -matrix_[k][j]);
    const double inverse = 1.0 / matrix_[k][k];
    for (double& value : rows_[k]) value *= inverse;
  }
}

/// Of the derivative of D over the segment's time.
Partials VariationalEquations::couple_integral(double elapsed) const {
  Partials sum{};
  add(sum, at_.couple, elapsed);
  for (std::size_t j = 0; j < nodes_; ++j) {
    double weight = 0.0;
    for (std::size_t i = 0; i < nodes_; ++i) weight += weight_[i] * pace_[i] * integral(j, i);
    add(sum, rows_[j], weight);
  }
  return sum;
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
  add(at_.couple_integral, couple_integral(elapsed), 1.0);
  at_.friction[kByMu] -= sign * (c_.normal.impulse(end.normal) - impulse);
  at_.friction[kByZeta] -= limit * (to.zeta.impulse - from.zeta.impulse);
  at_.friction[kByGravity] -= limit * (to.gravity.impulse - from.gravity.impulse);
  for (std::size_t i = 0; i < nodes_; ++i) add(at_.couple, rows_[i], weight_[i]);

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

void VariationalEquations::finish_grip(const Segment& segment) {
  const SegmentPoint& end = segment.end;
  const double per_alpha = 1.0 / s_.alpha, per_beta = 1.0 / c_.beta;
  const double tau = end.normal.tau, elapsed = tau - segment.from.tau;
  const GripStart start = start_of_grip(segment);
  Partials first = start.first, second = start.second;
  const Partials integral = couple_integral(elapsed);
  for (std::size_t i = 0; i < nodes_; ++i) {
    const double cosine = weight_[i] * to_cosine_[i], sine = weight_[i] * to_sine_[i];
    add(second, rows_[i], per_alpha * cosine);
    add(first, rows_[i], -per_alpha * sine);
    second[kByAlpha] += cosine * forcing_[i].alpha;
    second[kByKt] += cosine * forcing_[i].kt;
    second[kByCt] += cosine * forcing_[i].ct;
    first[kByAlpha] -= sine * forcing_[i].alpha;
    first[kByKt] -= sine * forcing_[i].kt;
    first[kByCt] -= sine * forcing_[i].ct;
    add(at_.couple, rows_[i], weight_[i]);
  }
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

void VariationalEquations::advance(const Segment& segment) {
  place_nodes(segment);
  const bool grips = segment.mode == ContactMode::grips;
  if (grips)
    place_grip(segment);
  else
    place_slip(segment);
  solve();
  if (grips)
    finish_grip(segment);
  else
    finish_slip(segment);
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
