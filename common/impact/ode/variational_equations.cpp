#include "common/impact/ode/variational_equations.hpp"

#include <cassert>
#include <utility>

#include "common/impact/ode/friction_law.hpp"

namespace strobe::impact::detail {

namespace {

/// (sine - t·cosine)/omega2 of an Oscillation, whatever sign omega2 has: -2 times the derivative of the sine
/// with respect to omega2. By its series where the difference would lose digits.
double turned_sine(double omega2, double t, const Oscillation& o) {
  const double z = omega2 * t * t;
  if (!(std::abs(z) <= 0.1)) return (o.sine - t * o.cosine) / omega2;
  // The next term is below 1e-13 of the first.
  return t * t * t *
         (1.0 / 3.0 - z * (1.0 / 30.0 - z * (1.0 / 840.0 - z * (1.0 / 45360.0 - z * (1.0 / 3991680.0)))));
}

/// A grip without couple about the stretch that holds the weight, exp(-b·t)·(first·C + second·S), and how it
/// changes with b and with omega2, its stretch at the start kept.
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

/// The share of the friction's limit that the stretch of a long slip comes to, depth·(y - g) + rate·y' + g,
/// and its derivatives with respect to i = c_t/k_t.
struct ParticularStretch {
  double depth, rate, depth_by_i, rate_by_i;

  ParticularStretch(double zeta, double i) {
    const double rest = 1.0 + i * (i - 2.0 * zeta), excess = 2.0 * zeta - i;
    rate = excess / rest;
    depth = 1.0 + rate * i;
    rate_by_i = -(1.0 + rate * (2.0 * i - 2.0 * zeta)) / rest;
    depth_by_i = rate + i * rate_by_i;
  }
};

/// exp(-zeta·tau) times the two solutions; without gravity they follow from the state.
Oscillation faded_oscillation(const System& s, const NormalState& at) {
  if (s.gravity == 0.0) return {at.rate + s.zeta * at.depth, at.depth};
  const Oscillation o = oscillation((1.0 - s.zeta) * (1.0 + s.zeta), at.tau);
  const double fade = std::exp(-s.zeta * at.tau);
  return {fade * o.cosine, fade * o.sine};
}

}  // namespace

NormalPartials normal_partials(const System& s, const NormalState& at) {
  const Oscillation o = faded_oscillation(s, at);
  NormalPartials p;
  p.depth = 1.0 - o.cosine - s.zeta * o.sine;
  p.rate = o.sine;
  p.force = p.depth + 2.0 * s.zeta * p.rate;
  p.force_rate = p.rate + 2.0 * s.zeta * (1.0 - p.force);
  p.impulse = at.tau - p.rate;
  return p;
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
  given_[i] = {of_foot * by_[i].depth + of_force * by_[i].force, -of_foot * share,
               pace_[i] * foot * sample.force * h, full * w * bend};
  of_spin_[i] = -full * s_.w_ref * bend;
}

/// What each node's couple adds to its impulse at the end and to a grip's integrals.
void VariationalEquations::weigh_nodes(bool grips) {
  for (std::size_t j = 0; j < nodes_; ++j) {
    weights_[j] = {weight_[j], grips ? weight_[j] * to_cosine_[j] : 0.0,
                   grips ? weight_[j] * to_sine_[j] : 0.0};
  }
}

void VariationalEquations::solve_slip(const Segment& segment) {
  const double limit = direction(segment.mode), per_alpha = 1.0 / s_.alpha;
  for (std::size_t j = 0; j < nodes_; ++j) {
    for (std::size_t i = 0; i < nodes_; ++i) matrix_[j][i] = -of_spin_[i] * per_alpha * integral(j, i);
    matrix_[j][j] += 1.0;
  }
  weigh_nodes(false);
  solve();
  sum_given();
  const double impulse = c_.normal.impulse(segment.from);
  const NormalPartials from = normal_partials(s_, segment.from);
  Ends all{}, by_mu{}, by_gravity{}, by_alpha{};
  for (std::size_t i = 0; i < nodes_; ++i) {
    // Friction's impulse from the rate: J = g·tau + 1 - y'.
    const NodeSample& sample = segment.samples[i];
    const double rate = sample.force_rate - 2.0 * s_.zeta * (s_.gravity - sample.force);
    const double since = s_.gravity * tau_[i] + (1.0 - rate) - impulse;
    const double of_spin = of_spin_[i] * per_alpha;
    add(all, weights_[i], of_spin);
    add(by_mu, weights_[i], -of_spin * limit * since);
    add(by_gravity, weights_[i], -of_spin * limit * s_.mu * (by_[i].impulse - from.impulse));
    add(by_alpha, weights_[i], -of_spin * (sample.spin - s_.w0));
  }
  Partials base{};
  add(base, at_.couple, 1.0);
  add(base, at_.friction, 1.0);
  sum(base, all);
  sum(kByMu, by_mu);
  sum(kByGravity, by_gravity);
  sum(kByAlpha, by_alpha);
}

void VariationalEquations::solve_grip(const Segment& segment, const GripStart& start) {
  const double per_alpha = 1.0 / s_.alpha, per_both = per_alpha / c_.beta;
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
  Nodes forced_alpha{}, forced_kt{}, forced_ct{};
  for (std::size_t j = 0; j < nodes_; ++j) {
    const Forcing& forcing = forcing_[j];
    for (std::size_t i = 0; i < nodes_; ++i) {
      const double green = integral(j, i) * (of_second[i] * to_cosine_[j] + of_first[i] * to_sine_[j]);
      forced_alpha[i] += green * forcing.alpha;
      forced_kt[i] += green * forcing.kt;
      forced_ct[i] += green * forcing.ct;
      matrix_[j][i] = -of_spin_[i] * per_both * (integral(j, i) + per_alpha * green);
    }
    matrix_[j][j] += 1.0;
  }
  weigh_nodes(true);
  solve();
  sum_given();
  // alpha·dw = D + P, and beta·P follows from the slip.
  Ends all{}, first{}, second{}, by_b{}, by_omega2{}, by_alpha{}, by_kt{}, by_ct{}, by_along{};
  for (std::size_t i = 0; i < nodes_; ++i) {
    const Ends& weights = weights_[i];
    const double of_spin = of_spin_[i] * per_both;
    const double turned = (segment.samples[i].spin - s_.w0) * per_alpha;
    add(all, weights, of_spin);
    add(first, weights, -of_spin * of_first[i]);
    add(second, weights, of_spin * of_second[i]);
    add(by_b, weights, of_spin * slip_by_b[i]);
    add(by_omega2, weights, of_spin * slip_by_omega2[i]);
    add(by_alpha, weights, of_spin * forced_alpha[i] + of_spin_[i] * turned * (per_both - 1.0));
    add(by_kt, weights, of_spin * forced_kt[i]);
    add(by_ct, weights, of_spin * forced_ct[i]);
    add(by_along, weights, -of_spin * tau_[i]);
  }
  sum(at_.couple, all);
  sum(start.first, first);
  sum(start.second, second);
  sum(start.b, by_b);
  sum(start.omega2, by_omega2);
  sum(kByAlpha, by_alpha);
  sum(kByKt, by_kt);
  sum(kByCt, by_ct);
  sum(kByAlong, by_along);
}

/// The weights of the right-hand sides from those of the solution: by the transposed matrix, with the largest
/// pivot.
void VariationalEquations::solve() {
  if (s_.delta == 0.0) return;
  const std::size_t n = nodes_;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::abs(matrix_[i][k]) > std::abs(matrix_[pivot][k])) pivot = i;
    if (pivot != k) {
      std::swap(matrix_[k], matrix_[pivot]);
      std::swap(weights_[k], weights_[pivot]);
    }
    const double inverse = 1.0 / matrix_[k][k];
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = matrix_[i][k] * inverse;
      for (std::size_t j = k + 1; j < n; ++j) matrix_[i][j] -= factor * matrix_[k][j];
      add(weights_[i], weights_[k], -factor);
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) add(weights_[k], weights_[j], -matrix_[k][j]);
    const double inverse = 1.0 / matrix_[k][k];
    for (double& value : weights_[k]) value *= inverse;
  }
}

void VariationalEquations::sum(const Partials& what, const Ends& times) {
  for (std::size_t f = 0; f < times.size(); ++f) add(ends_[f], what, times[f]);
}

void VariationalEquations::sum(SystemInput input, const Ends& times) {
  for (std::size_t f = 0; f < times.size(); ++f) ends_[f][input] += times[f];
}

/// What the couple's own law adds.
void VariationalEquations::sum_given() {
  for (Partials& end : ends_) end.fill(0.0);
  Ends by_gravity{}, by_radius{}, by_delta{}, by_reference{};
  for (std::size_t i = 0; i < nodes_; ++i) {
    add(by_gravity, weights_[i], given_[i].gravity);
    add(by_radius, weights_[i], given_[i].radius);
    add(by_delta, weights_[i], given_[i].delta);
    add(by_reference, weights_[i], given_[i].reference);
  }
  sum(kByGravity, by_gravity);
  sum(kByRadius, by_radius);
  sum(kByDelta, by_delta);
  sum(kByReference, by_reference);
}

/// s = slip0 + beta·P + D/alpha + g_x·t at all times.
Partials VariationalEquations::slip_of(const TangentialPartials& at, double tau, double spin) const {
  Partials slip{};
  add(slip, at.friction, c_.beta);
  add(slip, at.couple, 1.0 / s_.alpha);
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
  out[kByGravity] = limit * (1.0 + p.depth * (by.depth - 1.0) + p.rate * by.rate);
  return out;
}

void VariationalEquations::finish_slip(const Segment& segment) {
  const SegmentPoint& end = segment.end;
  const double sign = direction(segment.mode), limit = sign * s_.mu;
  const double elapsed = end.normal.tau - segment.from.tau;
  const NormalPartials from = normal_partials(s_, segment.from), to = normal_partials(s_, end.normal);
  at_.friction[kByMu] -= sign * (c_.normal.impulse(end.normal) - c_.normal.impulse(segment.from));
  at_.friction[kByGravity] -= limit * (to.impulse - from.impulse);
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
  Partials first = start.first, second = start.second;
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

  at_.friction.fill(0.0);
  add(at_.friction, slip, per_beta);
  add(at_.friction, at_.couple, -per_alpha * per_beta);
  at_.friction[kByAlong] -= per_beta * tau;
  at_.friction[kByAlpha] += per_beta * (c_.spin(end.tangential) - s_.w0) * per_alpha;
  at_.stretch = stretch;
}

}  // namespace strobe::impact::detail
