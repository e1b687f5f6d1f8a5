#include "common/impact/ode/segment_partials.hpp"

#include <cassert>
#include <utility>

#include "common/impact/ode/free_grip.hpp"

namespace strobe::impact::detail {

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
  given_[i] = {of_foot * by_[i].zeta.depth + of_force * by_[i].zeta.force,
               of_foot * by_[i].gravity.depth + of_force * by_[i].gravity.force, -of_foot * share,
               pace_[i] * foot * sample.force * h, full * w * bend};
  of_spin_[i] = -full * s_.w_ref * bend;
}

/// What each node's couple adds to its impulse at the end, to that integrated over time, and to a grip's integrals.
void VariationalEquations::weigh_nodes(bool grips) {
  for (std::size_t j = 0; j < nodes_; ++j) {
    double over_time = 0.0;
    for (std::size_t i = 0; i < nodes_; ++i) over_time += weight_[i] * pace_[i] * integral(j, i);
    weights_[j] = {weight_[j], over_time, grips ? weight_[j] * to_cosine_[j] : 0.0,
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
  Ends all{}, by_mu{}, by_zeta{}, by_gravity{}, by_alpha{};
  for (std::size_t i = 0; i < nodes_; ++i) {
    // Friction's impulse from the rate: J = g·tau + 1 - y'.
    const NodeSample& sample = segment.samples[i];
    const double rate = sample.force_rate - 2.0 * s_.zeta * (s_.gravity - sample.force);
    const double since = s_.gravity * tau_[i] + (1.0 - rate) - impulse;
    const double of_spin = of_spin_[i] * per_alpha;
    add(all, weights_[i], of_spin);
    add(by_mu, weights_[i], -of_spin * limit * since);
    add(by_zeta, weights_[i], -of_spin * limit * s_.mu * (by_[i].zeta.impulse - from.zeta.impulse));
    add(by_gravity, weights_[i], -of_spin * limit * s_.mu * (by_[i].gravity.impulse - from.gravity.impulse));
    add(by_alpha, weights_[i], -of_spin * (sample.spin - s_.w0));
  }
  Partials base{};
  add(base, at_.couple, 1.0);
  add(base, at_.friction, 1.0);
  base[kBySpin] += s_.alpha;
  sum(base, all);
  sum(kByMu, by_mu);
  sum(kByZeta, by_zeta);
  sum(kByGravity, by_gravity);
  sum(kByAlpha, by_alpha);
}

void VariationalEquations::solve_grip(const Segment& segment, const GripStart& start) {
  const double alpha = s_.alpha, per_alpha = 1.0 / alpha, per_both = per_alpha / c_.beta;
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
  Partials base = at_.couple;
  base[kBySlip] -= 1.0;
  base[kBySpin] += alpha * c_.beta;
  sum(base, all);
  sum(start.first, first);
  sum(start.second, second);
  sum(start.b, by_b);
  sum(start.omega2, by_omega2);
  sum(kByAlpha, by_alpha);
  sum(kByKt, by_kt);
  sum(kByCt, by_ct);
  sum(kByAlong, by_along);
}

/// The weights of the right-hand sides from those of the solution: by the transposed matrix, with the largest pivot.
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
  Ends by_zeta{}, by_gravity{}, by_radius{}, by_delta{}, by_reference{};
  for (std::size_t i = 0; i < nodes_; ++i) {
    add(by_zeta, weights_[i], given_[i].zeta);
    add(by_gravity, weights_[i], given_[i].gravity);
    add(by_radius, weights_[i], given_[i].radius);
    add(by_delta, weights_[i], given_[i].delta);
    add(by_reference, weights_[i], given_[i].reference);
  }
  sum(kByZeta, by_zeta);
  sum(kByGravity, by_gravity);
  sum(kByRadius, by_radius);
  sum(kByDelta, by_delta);
  sum(kByReference, by_reference);
}

void VariationalEquations::advance(const Segment& segment) {
  place_nodes(segment);
  if (segment.mode == ContactMode::grips) {
    const GripStart start = start_of_grip(segment);
    solve_grip(segment, start);
    finish_grip(segment, start);
    return;
  }
  solve_slip(segment);
  finish_slip(segment);
}

}  // namespace strobe::impact::detail
