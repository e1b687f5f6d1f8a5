// Solves one segment (collocation_segment.hpp) on n Gauss–Legendre nodes: the fixed point D = integral of
// K·h(w(D)) by Picard's iteration. At the segment's end the result is of order 2n, along it of order n + 1.
// Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include "common/impact/ode/segment_nodes.hpp"

namespace strobe::impact::detail {

template <std::size_t n, std::size_t terms = 17>
class SegmentSolver {
 public:
  using Nodes = SegmentNodes<n, terms>;
  using Row = std::array<double, n>;
  /// The nodes, then the end.
  using Points = typename Nodes::Points;

  /// `allowed`: error of D.
  SegmentSolver(const CollocationConstants& constants, double allowed)
      : c_(constants), allowed_(allowed), nodes_(constants) {}

  /// Solves the segment from its x, size, mode, from, start to `to`, its end. Returns false if the iteration
  /// does not converge; unless told to persist, also if its first values are resolved kHopeless times less
  /// than allowed. to.depth and to.rate are filled.
  bool solve(const Segment& segment, NormalState& to, bool persist);

  /// Of the last solve: error of D at the segment's end, estimated from the last two Legendre coefficients.
  /// Where they fall geometrically from a, that of P_0, to e, that of P_(n-2), that of P_2n, the first which
  /// Gauss's rule misses, is e·(e/a)^((n+2)/(n-2)); the power is rounded down to a root. What a pole near the
  /// segment adds is small but falls off more slowly: their last fall, from P_(n-4) on, goes on.
  double error_at_end() const;
  /// Of D between the nodes: e itself.
  double error_along() const { return last_; }

  /// Of D between the nodes of a segment that is left where its friction changes: the polynomial's first term
  /// that is not seen, P_n, and its integral.
  double error_inside() const { return 0.5 * last_ * std::sqrt(local_fall_) / static_cast<double>(n); }

  /// The state at a share of the segment by the polynomial.
  SegmentPoint point_at(const Segment& segment, double share) const;

  /// Fills the segment's samples.
  void sample(Segment& segment) const;
  /// Its coefficients, for point_on().
  void interpolate(Segment& segment) const;

  const TangentialState& end() const { return end_; }
  const Points& slip() const { return slip_; }
  const Points& stretch() const { return stretch_; }
  const Points& spin() const { return spin_; }
  const Points& force() const { return nodes_.force; }
  const Points& rate() const { return nodes_.rate; }
  int sweeps() const { return sweeps_; }

 private:
  static constexpr int kMaxSweeps = 14;
  static constexpr double kHopeless = 1.0;
  static constexpr std::size_t kPoints = Nodes::kPoints;
  static constexpr const GaussLegendre<n>& kRule = kGaussLegendre<n>;

  bool iterate(bool persist);
  double first_values();
  void values();
  double integrate();
  void spins();
  void finish(const Segment& segment, const NormalState& to);
  TangentialState state_of(const Segment& segment, const NormalState& to, double couple,
                           double couple_integral, double slip, double stretch,
                           double slipping_friction) const;
  void estimate();
  void estimate_of_couple();

  /// The larger of the last two Legendre coefficients of `value`, and of the two before.
  struct Tail {
    double last, before;
  };
  static Tail tail_of(const Points& value) {
    const std::array<double, 4> sum = last_coefficients<n>(value);
    return {std::max(std::abs(sum[3]), std::abs(sum[2])), std::max(std::abs(sum[1]), std::abs(sum[0]))};
  }
  static double coefficient(std::size_t k, const Points& value) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) sum += kRule.coefficient[k][i] * value[i];
    return sum;
  }

  const CollocationConstants& c_;
  double allowed_;
  bool grips_ = false;
  int sweeps_ = 0;
  double last_ = 0.0, largest_ = 0.0, local_fall_ = 1.0;
  TangentialState end_;
  Nodes nodes_;
  /// Along the segment: D's rate, and what the integrals are since its start.
  alignas(16) Points value_, couple_, cosine_, sine_;
  alignas(16) Points spin_, slip_, stretch_;
};

template <std::size_t n, std::size_t terms>
bool SegmentSolver<n, terms>::solve(const Segment& segment, NormalState& to, bool persist) {
  grips_ = segment.mode == ContactMode::grips;
  nodes_.place(segment, to);
  if (!iterate(persist)) return false;
  finish(segment, to);
  return true;
}

/// K·h(w) at the nodes without the couple. Returns what a sweep makes of a change of D: the integral of its
/// slope, half because D grows along with that integral.
template <std::size_t n, std::size_t terms>
double SegmentSolver<n, terms>::first_values() {
  spin_ = nodes_.free_spin;
  if (c_.system.ahead != 0.0) {
    const double ahead = c_.system.ahead;
    for (std::size_t i = 0; i < kPoints; ++i) value_[i] = nodes_.gain[i] * ahead;
    return 0.0;
  }
  const double w_ref2 = c_.system.w_ref * c_.system.w_ref;
  alignas(16) Points slope;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double inverse = 1.0 / std::sqrt(spin_[i] * spin_[i] + w_ref2);
    const double scaled = nodes_.gain[i] * inverse;
    value_[i] = -scaled * spin_[i];
    slope[i] = scaled * (w_ref2 * (inverse * inverse));
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) sum += kRule.weight[i] * slope[i];
  return 0.5 * sum / c_.system.alpha;
}

template <std::size_t n, std::size_t terms>
void SegmentSolver<n, terms>::values() {
  if (c_.system.ahead != 0.0) return;
  const double w_ref2 = c_.system.w_ref * c_.system.w_ref;
  for (std::size_t i = 0; i < kPoints; ++i)
    value_[i] = -nodes_.gain[i] * (spin_[i] / std::sqrt(spin_[i] * spin_[i] + w_ref2));
}

/// The integrals of the values. Returns the change of D.
template <std::size_t n, std::size_t terms>
double SegmentSolver<n, terms>::integrate() {
  alignas(16) Points couple;
  integrate_nodes<n>(value_, couple);
  if (grips_) {
    alignas(16) Points weighted;
    for (std::size_t i = 0; i < kPoints; ++i) weighted[i] = nodes_.of_cosine[i] * value_[i];
    integrate_nodes<n>(weighted, cosine_);
    for (std::size_t i = 0; i < kPoints; ++i) weighted[i] = nodes_.of_sine[i] * value_[i];
    integrate_nodes<n>(weighted, sine_);
  }
  double change = 0.0;
  for (std::size_t i = 0; i < kPoints; ++i) change = std::max(change, std::abs(couple[i] - couple_[i]));
  couple_ = couple;
  return change;
}

template <std::size_t n, std::size_t terms>
void SegmentSolver<n, terms>::spins() {
  const double per_alpha = 1.0 / c_.system.alpha;
  if (!grips_) {
    for (std::size_t i = 0; i < kPoints; ++i) spin_[i] = nodes_.free_spin[i] + couple_[i] * per_alpha;
    return;
  }
  const double whole2 = c_.beta * c_.system.kt;
  const double of_couple = per_alpha / c_.beta, of_slip = of_couple * per_alpha;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double slip = nodes_.cosine_rate[i] * cosine_[i] + whole2 * nodes_.sine[i] * sine_[i];
    spin_[i] = nodes_.free_spin[i] + (of_couple * couple_[i] + of_slip * slip);
  }
}

template <std::size_t n, std::size_t terms>
bool SegmentSolver<n, terms>::iterate(bool persist) {
  couple_.fill(0.0);
  cosine_.fill(0.0);
  sine_.fill(0.0);
  sweeps_ = 0;
  last_ = largest_ = 0.0;
  if (c_.system.delta == 0.0) {
    value_.fill(0.0);
    spin_ = nodes_.free_spin;
    return true;
  }
  double ratio = first_values();
  if (!persist) {
    estimate_of_couple();
    if (error_at_end() > kHopeless * allowed_) return false;
  }
  double before = 0.0;
  for (sweeps_ = 1; sweeps_ <= kMaxSweeps; ++sweeps_) {
    const double change = integrate();
    spins();
    if (sweeps_ > 1) ratio = change / before;
    // The next change is this one times the ratio at most, and falls off faster.
    if (change == 0.0 || change * std::min(ratio, 1.0) <= 0.3 * allowed_) {
      estimate();
      return true;
    }
    if (sweeps_ > 3 && ratio > 0.7) return false;
    before = change;
    values();
  }
  return false;
}

/// Slip and stretch at the points, and the state at the end.
template <std::size_t n, std::size_t terms>
void SegmentSolver<n, terms>::finish(const Segment& segment, const NormalState& to) {
  const double per_alpha = 1.0 / c_.system.alpha;
  if (grips_) {
    const double whole2 = c_.beta * c_.system.kt;
    for (std::size_t i = 0; i < kPoints; ++i) {
      slip_[i] = nodes_.free_slip[i] +
                 per_alpha * (nodes_.cosine_rate[i] * cosine_[i] + whole2 * nodes_.sine[i] * sine_[i]);
      stretch_[i] =
          nodes_.free_stretch[i] + per_alpha * (nodes_.sine[i] * cosine_[i] - nodes_.cosine[i] * sine_[i]);
    }
  } else {
    for (std::size_t i = 0; i < kPoints; ++i) slip_[i] = nodes_.free_slip[i] + couple_[i] * per_alpha;
    stretch_ = nodes_.free_stretch;
  }
  double couple_integral = 0.0;
  for (std::size_t i = 0; i < n; ++i) couple_integral += kRule.weight[i] * nodes_.pace[i] * couple_[i];
  end_ = state_of(segment, to, couple_[n], couple_integral, slip_[n], stretch_[n], nodes_.friction[n]);
}

/// From what the couple has done since the segment's start.
template <std::size_t n, std::size_t terms>
TangentialState SegmentSolver<n, terms>::state_of(const Segment& segment, const NormalState& to,
                                                  double couple, double couple_integral, double slip,
                                                  double stretch, double slipping_friction) const {
  const System& s = c_.system;
  const TangentialState& start = segment.start;
  const double per_alpha = 1.0 / s.alpha, elapsed = to.tau - segment.from.tau;
  TangentialState out;
  double path = start.friction * elapsed;
  if (grips_) {
    const double per_beta = 1.0 / c_.beta;
    out.friction =
        start.friction + ((slip - (start.slip + s.along * elapsed)) - couple * per_alpha) * per_beta;
    path += ((stretch - start.stretch) - (start.slip + 0.5 * s.along * elapsed) * elapsed -
             couple_integral * per_alpha) *
            per_beta;
  } else {
    out.friction = slipping_friction;
    path -= direction(segment.mode) * s.mu *
            ((c_.normal.impulse_integral(to) - c_.normal.impulse_integral(segment.from)) -
             c_.normal.impulse(segment.from) * elapsed);
  }
  out.couple = start.couple + couple;
  out.slip = slip;
  out.stretch = stretch;
  out.path = start.path + path;
  out.angle = start.angle + (start.couple * elapsed + couple_integral + path) * per_alpha;
  return out;
}

template <std::size_t n, std::size_t terms>
SegmentPoint SegmentSolver<n, terms>::point_at(const Segment& segment, double share) const {
  const auto at = nodes_.at(segment, c_.normal.tau(segment.x + segment.size * share));
  alignas(16) Points weight;
  integral_weights<n>(share, weight);
  double couple = 0.0, couple_integral = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double part = weight[i] * value_[i];
    couple += part;
    couple_integral += part * (at.normal.tau - nodes_.tau[i]);
  }
  double slip = at.slip, stretch = at.stretch;
  const double per_alpha = 1.0 / c_.system.alpha;
  if (grips_) {
    double cosine = 0.0, sine = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double part = weight[i] * value_[i];
      cosine += part * nodes_.of_cosine[i];
      sine += part * nodes_.of_sine[i];
    }
    slip += per_alpha * (at.cosine_rate * cosine + c_.beta * c_.system.kt * at.sine * sine);
    stretch += per_alpha * (at.sine * cosine - at.cosine * sine);
  } else {
    slip += couple * per_alpha;
  }
  return {at.normal, state_of(segment, at.normal, couple, couple_integral, slip, stretch, at.friction)};
}

template <std::size_t n, std::size_t terms>
void SegmentSolver<n, terms>::estimate_of_couple() {
  const Tail tail = tail_of(value_);
  last_ = tail.last;
  largest_ = 0.0;
  for (std::size_t i = 0; i < n; ++i) largest_ = std::max(largest_, std::abs(value_[i]));
  local_fall_ = tail.last < tail.before ? tail.last / tail.before : 1.0;
}

template <std::size_t n, std::size_t terms>
void SegmentSolver<n, terms>::estimate() {
  estimate_of_couple();
  if (!grips_ || largest_ == 0.0) return;
  // What an error of the two weighted integrals does to the slip at the end.
  alignas(16) Points cosine, sine;
  for (std::size_t i = 0; i < kPoints; ++i) {
    cosine[i] = nodes_.of_cosine[i] * value_[i];
    sine[i] = nodes_.of_sine[i] * value_[i];
  }
  const double last = std::abs(nodes_.cosine_rate[n]) * tail_of(cosine).last +
                      std::abs(c_.beta * c_.system.kt * nodes_.sine[n]) * tail_of(sine).last;
  last_ = std::max(last_, last / c_.beta);
}

template <std::size_t n, std::size_t terms>
double SegmentSolver<n, terms>::error_at_end() const {
  if (last_ == 0.0) return 0.0;
  const double fall = std::min(1.0, last_ / largest_);
  const double whole = fall * (n <= 8 ? std::sqrt(fall) : std::sqrt(std::sqrt(fall)));
  double local = 1.0;
  for (std::size_t k = n - 2; k < 2 * n; k += 2) local *= local_fall_;
  return last_ * std::max(whole, local);
}

template <std::size_t n, std::size_t terms>
void SegmentSolver<n, terms>::sample(Segment& segment) const {
  segment.nodes = n;
  const System& s = c_.system;
  for (std::size_t i = 0; i < n; ++i) {
    const double pace = nodes_.pace[i], force = nodes_.force[i];
    segment.samples[i] = {kRule.weight[i] * pace,
                          force,
                          nodes_.rate[i] + 2.0 * s.zeta * (s.gravity - force),
                          pace > 0.0 ? value_[i] / pace : 0.0,
                          slip_[i],
                          stretch_[i],
                          spin_[i]};
  }
}

template <std::size_t n, std::size_t terms>
void SegmentSolver<n, terms>::interpolate(Segment& segment) const {
  for (std::size_t k = 0; k < n; ++k) segment.couple[k] = coefficient(k, value_);
  if (segment.mode != ContactMode::grips) return;
  alignas(16) Points cosine, sine;
  for (std::size_t i = 0; i < kPoints; ++i) {
    cosine[i] = nodes_.of_cosine[i] * value_[i];
    sine[i] = nodes_.of_sine[i] * value_[i];
  }
  for (std::size_t k = 0; k < n; ++k) {
    segment.cosine[k] = coefficient(k, cosine);
    segment.sine[k] = coefficient(k, sine);
  }
}

}  // namespace strobe::impact::detail
