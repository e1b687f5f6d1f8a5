// Solves one segment (collocation_segment.hpp) on n Gauss–Legendre nodes: the fixed point D = integral of K·h(w(D))
// by Picard's iteration. At the segment's end the result is of order 2n, along it of order n + 1.
// Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include "common/impact/ode/collocation_segment.hpp"

namespace strobe::impact::detail {

template <std::size_t n>
class SegmentSolver {
 public:
  using Row = std::array<double, n>;
  /// The nodes, the end, and one more so that their number is even.
  using Points = std::array<double, n + 2>;

  /// `allowed`: error of D.
  SegmentSolver(const CollocationConstants& constants, double allowed) : c_(constants), allowed_(allowed) {}

  /// Solves the segment from its x, size, mode, from, start to `to`, its end. Returns false if the iteration does
  /// not converge; unless told to persist, also if its first values are resolved kHopeless times less than allowed.
  /// to.depth and to.rate are filled.
  bool solve(const Segment& segment, NormalState& to, bool persist);

  /// Of the last solve: error of D at the segment's end, estimated from the last two Legendre coefficients. Where
  /// they fall geometrically from a, that of P_0, to e, that of P_(n-2), that of P_2n, the first which Gauss's rule
  /// misses, is e·(e/a)^((n+2)/(n-2)); the power is rounded down to a root. What a pole near the segment adds is
  /// small but falls off more slowly: their last fall, from P_(n-4) on, goes on.
  double error_at_end() const;
  /// Of D between the nodes: e itself.
  double error_along() const { return last_; }

  /// Fills the segment's coefficients, for point_on(), and its samples.
  void interpolate(Segment& segment) const;

  const TangentialState& end() const { return end_; }
  const Row& slip() const { return slip_; }
  const Row& stretch() const { return stretch_; }
  const Row& force() const { return force_; }
  const Points& rate() const { return rate_; }
  const Row& spin() const { return spin_; }
  const Row& pace() const { return pace_; }
  const Row& couple_rate() const { return value_; }  ///< times pace
  int sweeps() const { return sweeps_; }

 private:
  static constexpr int kMaxSweeps = 14;
  static constexpr double kHopeless = 10.0;
  static constexpr const GaussLegendre<n>& kRule = kGaussLegendre<n>;

  void place_nodes(const Segment& segment, NormalState& to);
  void place_grip(const Segment& segment);
  void slip_stretches(const Segment& segment);
  void evaluate(const Segment& segment);
  bool iterate(const Segment& segment, bool persist);
  void finish(const Segment& segment, const NormalState& to);
  void estimate(bool grips);

  static void integrate(const Row& value, Row& sum) {
    alignas(16) Row local{};
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t i = 0; i < n; ++i) local[i] += kRule.integral[j][i] * value[j];
    sum = local;
  }
  static double weighted(const Row& value) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) sum += kRule.weight[i] * value[i];
    return sum;
  }
  static double coefficient(std::size_t k, const Row& value) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) sum += kRule.coefficient[k][i] * value[i];
    return sum;
  }
  static double largest(const Row& value) {
    double most = 0.0;
    for (const double v : value) most = std::max(most, std::abs(v));
    return most;
  }

  const CollocationConstants& c_;
  double allowed_;
  int sweeps_ = 0;
  double last_ = 0.0, largest_ = 0.0, local_fall_ = 1.0;
  TangentialState end_;
  // Functions of time alone.
  alignas(16) Points tau_, depth_, rate_;
  alignas(16) Row pace_, force_, gain_;
  alignas(16) Row base_;       // slipping: friction's impulse
  alignas(16) Row free_slip_;  // gripping: without friction and couple
  alignas(16) Row couple_, value_, spin_, slip_, stretch_;
  // Gripping: weights of the two integrals, and the solutions.
  alignas(16) Points fade_, grip_cosine_, grip_sine_;
  alignas(16) Row to_cosine_, to_sine_, of_second_, of_first_;
  alignas(16) Row cosine_, sine_;
};

template <std::size_t n>
void SegmentSolver<n>::place_nodes(const Segment& segment, NormalState& to) {
  const NormalMotion& normal = c_.normal;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = segment.x + segment.size * kRule.node[i];
    tau_[i] = normal.tau(x);
    pace_[i] = segment.size * normal.pace(x);
  }
  tau_[n] = tau_[n + 1] = to.tau;
  normal.along(tau_, depth_, rate_);
  to.depth = depth_[n];
  to.rate = rate_[n];
  const double zeta2 = 2.0 * c_.system.zeta;
  const double per_radius = 1.0 / c_.system.radius;
  const double delta = c_.system.delta;
  for (std::size_t i = 0; i < n; ++i) {
    force_[i] = depth_[i] + zeta2 * rate_[i];
    const double share = std::min(std::max(depth_[i] * per_radius, 0.0), 1.0);
    gain_[i] = delta * std::sqrt(share * (2.0 - share)) * (force_[i] * pace_[i]);
  }
}

template <std::size_t n>
void SegmentSolver<n>::place_grip(const Segment& segment) {
  alignas(16) Points elapsed;
  for (std::size_t i = 0; i < n + 2; ++i) elapsed[i] = tau_[i] - segment.from.tau;
  const double whole = elapsed[n];
  oscillation_along(c_.omega2, std::abs(c_.omega2) * whole * whole <= kMaxSeriesPhase2, elapsed, grip_cosine_,
                    grip_sine_);
  if (c_.b > 0.0)
    for (std::size_t i = 0; i <= n; ++i) fade_[i] = std::exp(-c_.b * elapsed[i]);
  else
    fade_.fill(1.0);
  const double b = c_.b, omega2 = c_.omega2;
  for (std::size_t i = 0; i < n; ++i) {
    const double grow = 1.0 / fade_[i];
    to_cosine_[i] = grow * grip_cosine_[i];
    to_sine_[i] = grow * grip_sine_[i];
    free_slip_[i] = segment.start.slip + c_.system.along * elapsed[i];
    const double cosine = fade_[i] * grip_cosine_[i], sine = fade_[i] * grip_sine_[i];
    of_second_[i] = cosine - b * sine;
    of_first_[i] = b * cosine + omega2 * sine;
  }
}

/// K·h(w) at the nodes from the couple and the slip there.
template <std::size_t n>
void SegmentSolver<n>::evaluate(const Segment& segment) {
  const double per_alpha = 1.0 / c_.system.alpha;
  const TangentialState& start = segment.start;
  if (segment.mode == ContactMode::grips) {
    const double per_beta = 1.0 / c_.beta;
    const double first = start.stretch - c_.rest;
    const double second = start.slip + c_.b * first;
    const double base = start.friction + start.couple;
    for (std::size_t i = 0; i < n; ++i) {
      slip_[i] =
          (second + per_alpha * cosine_[i]) * of_second_[i] - (first - per_alpha * sine_[i]) * of_first_[i];
      const double friction = ((slip_[i] - free_slip_[i]) - couple_[i] * per_alpha) * per_beta;
      spin_[i] = c_.system.w0 + (base + (couple_[i] + friction)) * per_alpha;
    }
  } else {
    const double base = start.couple;
    for (std::size_t i = 0; i < n; ++i)
      spin_[i] = c_.system.w0 + (base_[i] + (base + couple_[i])) * per_alpha;
  }
  if (c_.system.ahead != 0.0) {
    for (std::size_t i = 0; i < n; ++i) value_[i] = gain_[i] * c_.system.ahead;
    return;
  }
  const double w_ref2 = c_.system.w_ref * c_.system.w_ref;
  for (std::size_t i = 0; i < n; ++i)
    value_[i] = -gain_[i] * (spin_[i] / std::sqrt(spin_[i] * spin_[i] + w_ref2));
}

template <std::size_t n>
bool SegmentSolver<n>::iterate(const Segment& segment, bool persist) {
  const bool grips = segment.mode == ContactMode::grips;
  couple_.fill(0.0);
  cosine_.fill(0.0);
  sine_.fill(0.0);
  evaluate(segment);
  sweeps_ = 0;
  last_ = largest_ = 0.0;
  if (c_.system.delta == 0.0) return true;
  estimate(grips);
  if (!persist && error_at_end() > kHopeless * allowed_) return false;
  double before = 0.0;
  for (sweeps_ = 1; sweeps_ <= kMaxSweeps; ++sweeps_) {
    alignas(16) Row next;
    integrate(value_, next);
    double change = 0.0;
    for (std::size_t i = 0; i < n; ++i) change = std::max(change, std::abs(next[i] - couple_[i]));
    couple_ = next;
    if (grips) {
      alignas(16) Row weighted_value;
      for (std::size_t i = 0; i < n; ++i) weighted_value[i] = to_cosine_[i] * value_[i];
      integrate(weighted_value, cosine_);
      for (std::size_t i = 0; i < n; ++i) weighted_value[i] = to_sine_[i] * value_[i];
      integrate(weighted_value, sine_);
    }
    evaluate(segment);
    if (change == 0.0) return true;
    if (sweeps_ < 2) {
      before = change;
      continue;
    }
    // What is evaluated now is nearer than the change by one factor of the convergence.
    const double ratio = change / before;
    if (change * std::min(ratio, 1.0) <= 0.2 * allowed_) return true;
    if (sweeps_ > 3 && ratio > 0.7) return false;
    before = change;
  }
  return false;
}

template <std::size_t n>
void SegmentSolver<n>::slip_stretches(const Segment& segment) {
  const double sign = direction(segment.mode);
  const double limit = sign * c_.system.mu / c_.system.kt;
  if (c_.kappa == 0.0) {
    for (std::size_t i = 0; i < n; ++i) stretch_[i] = limit * force_[i];
    return;
  }
  const double g = c_.system.gravity;
  const double transient = segment.start.stretch - c_.slipping_stretch(segment.from, sign);
  for (std::size_t i = 0; i < n; ++i)
    stretch_[i] = limit * (g + (c_.particular_depth * (depth_[i] - g) + c_.particular_rate * rate_[i])) +
                  transient * std::exp(-c_.kappa * (tau_[i] - segment.from.tau));
}

template <std::size_t n>
void SegmentSolver<n>::finish(const Segment& segment, const NormalState& to) {
  const System& s = c_.system;
  const TangentialState& start = segment.start;
  const double couple = weighted(value_);
  const double elapsed = to.tau - segment.from.tau;
  double couple_integral = 0.0;
  for (std::size_t i = 0; i < n; ++i) couple_integral += kRule.weight[i] * pace_[i] * couple_[i];
  end_.couple = start.couple + couple;
  double path = start.friction * elapsed;
  if (segment.mode == ContactMode::grips) {
    double cosine = 0.0, sine = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      cosine += kRule.weight[i] * to_cosine_[i] * value_[i];
      sine += kRule.weight[i] * to_sine_[i] * value_[i];
    }
    const Grip grip = grip_at(c_, start, fade_[n], {grip_cosine_[n], grip_sine_[n]}, cosine, sine);
    end_.slip = grip.slip;
    end_.stretch = grip.stretch;
    end_.friction =
        start.friction + ((grip.slip - (start.slip + s.along * elapsed)) - couple / s.alpha) / c_.beta;
    path += ((grip.stretch - start.stretch) - (start.slip + 0.5 * s.along * elapsed) * elapsed -
             couple_integral / s.alpha) /
            c_.beta;
    const double per_alpha = 1.0 / s.alpha;
    const double first = start.stretch - c_.rest;
    const double second = start.slip + c_.b * first;
    for (std::size_t i = 0; i < n; ++i)
      stretch_[i] = c_.rest + fade_[i] * ((first - per_alpha * sine_[i]) * grip_cosine_[i] +
                                          (second + per_alpha * cosine_[i]) * grip_sine_[i]);
  } else {
    const double limit = direction(segment.mode) * s.mu;
    const double impulse = c_.normal.impulse(segment.from);
    end_.friction = start.friction - limit * (c_.normal.impulse(to) - impulse);
    end_.slip =
        start.slip + (c_.beta * (end_.friction - start.friction) + couple / s.alpha) + s.along * elapsed;
    end_.stretch = c_.slipping_stretch(to, direction(segment.mode));
    if (c_.kappa > 0.0)
      end_.stretch += std::exp(-c_.kappa * elapsed) *
                      (start.stretch - c_.slipping_stretch(segment.from, direction(segment.mode)));
    path -= limit *
            ((c_.normal.impulse_integral(to) - c_.normal.impulse_integral(segment.from)) - impulse * elapsed);
    const double per_alpha = 1.0 / s.alpha;
    for (std::size_t i = 0; i < n; ++i)
      slip_[i] = start.slip + (c_.beta * (base_[i] - start.friction) + couple_[i] * per_alpha) +
                 s.along * (tau_[i] - segment.from.tau);
    slip_stretches(segment);
  }
  end_.path = start.path + path;
  end_.angle = start.angle + (start.couple * elapsed + couple_integral + path) / s.alpha;
}

template <std::size_t n>
void SegmentSolver<n>::estimate(bool grips) {
  last_ = std::max(std::abs(coefficient(n - 1, value_)), std::abs(coefficient(n - 2, value_)));
  largest_ = largest(value_);
  const double before = std::max(std::abs(coefficient(n - 3, value_)), std::abs(coefficient(n - 4, value_)));
  local_fall_ = last_ < before ? last_ / before : 1.0;
  if (!grips || largest_ == 0.0) return;
  // What an error of the two weighted integrals does to the slip at the end.
  alignas(16) Row cosine, sine;
  for (std::size_t i = 0; i < n; ++i) {
    cosine[i] = to_cosine_[i] * value_[i];
    sine[i] = to_sine_[i] * value_[i];
  }
  const double turned = std::abs(grip_cosine_[n]), sine_at_end = std::abs(grip_sine_[n]);
  const double of_cosine = fade_[n] * (turned + c_.b * sine_at_end);
  const double of_sine = fade_[n] * (c_.b * turned + std::abs(c_.omega2) * sine_at_end);
  const double last =
      of_cosine * std::max(std::abs(coefficient(n - 1, cosine)), std::abs(coefficient(n - 2, cosine))) +
      of_sine * std::max(std::abs(coefficient(n - 1, sine)), std::abs(coefficient(n - 2, sine)));
  last_ = std::max(last_, last / c_.beta);
}

template <std::size_t n>
double SegmentSolver<n>::error_at_end() const {
  if (last_ == 0.0) return 0.0;
  const double fall = std::min(1.0, last_ / largest_);
  const double whole = fall * (n <= 8 ? std::sqrt(fall) : std::sqrt(std::sqrt(fall)));
  double local = 1.0;
  for (std::size_t k = n - 2; k < 2 * n; k += 2) local *= local_fall_;
  return last_ * std::max(whole, local);
}

template <std::size_t n>
bool SegmentSolver<n>::solve(const Segment& segment, NormalState& to, bool persist) {
  place_nodes(segment, to);
  if (segment.mode == ContactMode::grips) {
    place_grip(segment);
  } else {
    const double limit = direction(segment.mode) * c_.system.mu;
    const double impulse = c_.normal.impulse(segment.from);
    for (std::size_t i = 0; i < n; ++i)
      base_[i] =
          segment.start.friction - limit * (c_.normal.impulse({tau_[i], depth_[i], rate_[i]}) - impulse);
  }
  if (!iterate(segment, persist)) return false;
  finish(segment, to);
  estimate(segment.mode == ContactMode::grips);
  return true;
}

template <std::size_t n>
void SegmentSolver<n>::interpolate(Segment& segment) const {
  segment.nodes = n;
  const System& s = c_.system;
  for (std::size_t i = 0; i < n; ++i) {
    const double force_rate = rate_[i] + 2.0 * s.zeta * (s.gravity - force_[i]);
    segment.samples[i] = {kRule.weight[i] * pace_[i],
                          force_[i],
                          force_rate,
                          pace_[i] > 0.0 ? value_[i] / pace_[i] : 0.0,
                          slip_[i],
                          stretch_[i],
                          spin_[i]};
  }
  for (std::size_t k = 0; k < n; ++k) segment.couple[k] = coefficient(k, value_);
  if (segment.mode != ContactMode::grips) return;
  alignas(16) Row cosine, sine;
  for (std::size_t i = 0; i < n; ++i) {
    cosine[i] = to_cosine_[i] * value_[i];
    sine[i] = to_sine_[i] * value_[i];
  }
  for (std::size_t k = 0; k < n; ++k) {
    segment.cosine[k] = coefficient(k, cosine);
    segment.sine[k] = coefficient(k, sine);
  }
}

}  // namespace strobe::impact::detail
