// The two solutions of v'' + 2b·v' + f·v = 0, whichever its damping, at several times at once: S with S(0) =
// 0, S'(0) = 1; its rate V = S'; W = V + 2b·S has W(0) = 1, W'(0) = 0. Taylor's series of the time halved
// until 0.8 of the fastest decay or turn remains, then doubled as often. Without a branch or a library's
// function in its loops: compilers take several times in one instruction, and all give the same bits. Pure,
// no allocation: thread-safe, real-time safe.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "common/impact/ode/collocation_segment.hpp"

namespace strobe::impact::detail {

/// `terms` of the series: the first left out is 0.8^terms/terms! of the first, and counts twice per doubling.
template <std::size_t terms>
class DampedSeries {
 public:
  DampedSeries(double b, double f) : b_(b), f_(f) {
    const double b2 = b * b;
    fastest_ = b2 > f ? b + std::sqrt(b2 - f) : std::sqrt(f);
    v_[0] = 1.0;
    v_[1] = -2.0 * b;
    for (std::size_t k = 2; k < terms; ++k)
      v_[k] = -(2.0 * b * kInverse.of[k] * v_[k - 1] + f * kInverse.of[k] * kInverse.of[k - 1] * v_[k - 2]);
    for (std::size_t k = 0; k < terms; ++k) s_[k] = v_[k] * kInverse.of[k + 1];
  }

  /// `longest`: of the times.
  template <std::size_t n>
  void along(const std::array<double, n>& times, double longest, std::array<double, n>& sine,
             std::array<double, n>& rate) const {
    double part = 1.0;
    const int halvings = halve(fastest_ * longest, part);
    for (std::size_t i = 0; i < n; ++i) {
      const double t = part * times[i];
      double s = s_[terms - 1], v = v_[terms - 1];
      for (std::size_t k = terms - 1; k-- > 0;) {
        s = s_[k] + s * t;
        v = v_[k] + v * t;
      }
      sine[i] = s * t;
      rate[i] = v;
    }
    for (int k = 0; k < halvings; ++k) {
      for (std::size_t i = 0; i < n; ++i) {
        const double s = sine[i], v = rate[i];
        sine[i] = 2.0 * s * (v + b_ * s);
        rate[i] = v * v - f_ * (s * s);
      }
    }
  }

  /// exp(speed·t), by the same means.
  template <std::size_t n>
  static void exponentials(double speed, const std::array<double, n>& times, double longest,
                           std::array<double, n>& out) {
    double part = speed;
    const int halvings = halve(std::abs(speed) * longest, part);
    for (std::size_t i = 0; i < n; ++i) {
      const double x = part * times[i];
      double e = kFactorials.inverse[terms - 1];
      for (std::size_t k = terms - 1; k-- > 0;) e = kFactorials.inverse[k] + e * x;
      out[i] = e;
    }
    for (int k = 0; k < halvings; ++k)
      for (std::size_t i = 0; i < n; ++i) out[i] *= out[i];
  }

 private:
  struct Inverse {
    std::array<double, terms + 1> of{};
    constexpr Inverse() {
      for (std::size_t k = 1; k <= terms; ++k) of[k] = 1.0 / static_cast<double>(k);
    }
  };
  struct Factorials {
    std::array<double, terms> inverse{};
    constexpr Factorials() {
      double factorial = 1.0;
      for (std::size_t k = 0; k < terms; ++k) {
        if (k > 0) factorial *= static_cast<double>(k);
        inverse[k] = 1.0 / factorial;
      }
    }
  };
  static constexpr Inverse kInverse{};
  static constexpr Factorials kFactorials{};

  static int halve(double phase, double& part) {
    int halvings = 0;
    for (; phase > 0.8 && halvings < 60; phase *= 0.5, part *= 0.5) ++halvings;
    return halvings;
  }

  double b_, f_, fastest_;
  std::array<double, terms> s_, v_;
};

// What a segment's solution (segment_solver.hpp) needs of time alone, at the nodes and at the end: the normal
// motion, the couple it may have, and how the tangential motion would go on without that couple. Pure, no
// allocation: thread-safe, real-time safe.

/// `terms`: of DampedSeries.
template <std::size_t n, std::size_t terms>
class SegmentNodes {
 public:
  static constexpr const GaussLegendre<n>& kRule = kGaussLegendre<n>;
  using Points = typename GaussLegendre<n>::Points;
  static constexpr std::size_t kPoints = GaussLegendre<n>::points;

  explicit SegmentNodes(const CollocationConstants& constants)
      : c_(constants),
        normal_(constants.system.zeta, 1.0),
        grip_(constants.b, constants.beta * constants.system.kt) {}

  /// From the segment's x, size, mode, from and start to `to`, its end, whose depth and rate are filled.
  void place(const Segment& segment, NormalState& to);

  /// The solutions at one time alone: what place() fills at a point.
  struct Moment {
    NormalState normal;
    double sine, cosine_rate, cosine;      ///< gripping
    double slip, stretch, friction = 0.0;  ///< without the couple
  };
  Moment at(const Segment& segment, double tau) const;

  alignas(16) Points tau, pace, depth, rate, force;
  alignas(16) Points gain;  ///< what times -h(w) is the couple's rate along the segment
  /// Without the couple since the segment's start.
  alignas(16) Points free_spin, free_slip, free_stretch;
  alignas(16) Points friction;  ///< slipping: its impulse
  /// Gripping: the solutions, and the weights of the integrals of exp(2bt)·S·D',
  /// exp(2bt)·W·D'.
  alignas(16) Points sine, cosine_rate, cosine, of_sine, of_cosine;

 private:
  void place_normal(const Segment& segment, NormalState& to);
  void place_slip(const Segment& segment);
  void place_grip(const Segment& segment);

  const CollocationConstants& c_;
  DampedSeries<terms> normal_, grip_;
};

template <std::size_t n, std::size_t terms>
void SegmentNodes<n, terms>::place(const Segment& segment, NormalState& to) {
  place_normal(segment, to);
  if (segment.mode == ContactMode::grips)
    place_grip(segment);
  else
    place_slip(segment);
}

template <std::size_t n, std::size_t terms>
void SegmentNodes<n, terms>::place_normal(const Segment& segment, NormalState& to) {
  const NormalMotion normal = c_.normal;
  const double x = segment.x, size = segment.size;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double at = x + size * kRule.share[i];
    tau[i] = normal.tau(at);
    pace[i] = size * normal.pace(at);
  }
  for (std::size_t i = n; i < kPoints; ++i) tau[i] = to.tau;
  normal_.along(tau, to.tau, depth, rate);
  const double gravity = c_.system.gravity;
  if (gravity != 0.0) {
    const double zeta2 = 2.0 * c_.system.zeta;
    for (std::size_t i = 0; i < kPoints; ++i) {
      const double sine_at = depth[i], rate_at = rate[i];
      depth[i] = gravity + (sine_at - gravity * (rate_at + zeta2 * sine_at));
      rate[i] = rate_at + gravity * sine_at;
    }
  }
  to.depth = depth[n];
  to.rate = rate[n];
  const double zeta2 = 2.0 * c_.system.zeta;
  const double per_radius = 1.0 / c_.system.radius;
  const double delta = c_.system.delta;
  for (std::size_t i = 0; i < kPoints; ++i) {
    force[i] = depth[i] + zeta2 * rate[i];
    const double share = std::min(std::max(depth[i] * per_radius, 0.0), 1.0);
    gain[i] = delta * std::sqrt(share * (2.0 - share)) * (force[i] * pace[i]);
  }
}

template <std::size_t n, std::size_t terms>
void SegmentNodes<n, terms>::place_slip(const Segment& segment) {
  const System& s = c_.system;
  const TangentialState& start = segment.start;
  const double sign = direction(segment.mode), limit = sign * s.mu, stretch_limit = limit / s.kt;
  const double gravity = s.gravity, beta = c_.beta, per_alpha = 1.0 / s.alpha;
  const double impulse = 1.0 - c_.normal.impulse(segment.from);
  const double spin = s.w0 + start.couple * per_alpha;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double change = limit * (gravity * tau[i] + (impulse - rate[i]));
    friction[i] = start.friction - change;
    free_slip[i] = start.slip - beta * change;
    free_spin[i] = spin + friction[i] * per_alpha;
  }
  if (s.along != 0.0)
    for (std::size_t i = 0; i < kPoints; ++i) free_slip[i] += s.along * (tau[i] - segment.from.tau);
  if (c_.kappa == 0.0) {
    for (std::size_t i = 0; i < kPoints; ++i) free_stretch[i] = stretch_limit * force[i];
    return;
  }
  const double of_depth = c_.particular_depth, of_rate = c_.particular_rate;
  for (std::size_t i = 0; i < kPoints; ++i)
    free_stretch[i] = stretch_limit * (gravity + (of_depth * (depth[i] - gravity) + of_rate * rate[i]));
  const double transient = start.stretch - c_.slipping_stretch(segment.from, sign);
  if (transient == 0.0) return;
  alignas(16) Points elapsed, fade;
  for (std::size_t i = 0; i < kPoints; ++i) elapsed[i] = tau[i] - segment.from.tau;
  DampedSeries<terms>::exponentials(-c_.kappa, elapsed, elapsed[n], fade);
  for (std::size_t i = 0; i < kPoints; ++i) free_stretch[i] += transient * fade[i];
}

template <std::size_t n, std::size_t terms>
void SegmentNodes<n, terms>::place_grip(const Segment& segment) {
  const System& s = c_.system;
  const TangentialState& start = segment.start;
  alignas(16) Points elapsed, grow;
  for (std::size_t i = 0; i < kPoints; ++i) elapsed[i] = tau[i] - segment.from.tau;
  grip_.along(elapsed, elapsed[n], sine, cosine_rate);
  const double twice_b = 2.0 * c_.b, whole2 = c_.beta * s.kt;
  if (c_.b > 0.0)
    DampedSeries<terms>::exponentials(twice_b, elapsed, elapsed[n], grow);
  else
    grow.fill(1.0);
  const double slip = start.slip, rest = c_.rest, stretch = start.stretch - rest, along = s.along;
  const double per_beta = 1.0 / c_.beta, per_alpha = 1.0 / s.alpha;
  const double spin = s.w0 + (start.couple + start.friction) * per_alpha, per_both = per_alpha * per_beta;
  for (std::size_t i = 0; i < kPoints; ++i) {
    cosine[i] = cosine_rate[i] + twice_b * sine[i];
    of_sine[i] = grow[i] * sine[i];
    of_cosine[i] = grow[i] * cosine[i];
    free_slip[i] = slip * cosine_rate[i] - stretch * (whole2 * sine[i]);
    free_stretch[i] = rest + (slip * sine[i] + stretch * cosine[i]);
    free_spin[i] = spin + (free_slip[i] - (slip + along * elapsed[i])) * per_both;
  }
}

template <std::size_t n, std::size_t terms>
typename SegmentNodes<n, terms>::Moment SegmentNodes<n, terms>::at(const Segment& segment,
                                                                   double time) const {
  const System& s = c_.system;
  const TangentialState& start = segment.start;
  alignas(16) const std::array<double, 2> times{time, time};
  alignas(16) std::array<double, 2> of_sine_at, of_rate_at;
  normal_.along(times, time, of_sine_at, of_rate_at);
  const double y = of_sine_at[0], v = of_rate_at[0], g = s.gravity;
  Moment m{};
  m.normal = {time, g == 0.0 ? y : g + (y - g * (v + 2.0 * s.zeta * y)), v + g * y};
  const double elapsed = time - segment.from.tau;
  if (segment.mode == ContactMode::grips) {
    alignas(16) const std::array<double, 2> since{elapsed, elapsed};
    grip_.along(since, elapsed, of_sine_at, of_rate_at);
    m.sine = of_sine_at[0];
    m.cosine_rate = of_rate_at[0];
    m.cosine = m.cosine_rate + 2.0 * c_.b * m.sine;
    const double stretch = start.stretch - c_.rest;
    m.slip = start.slip * m.cosine_rate - stretch * (c_.beta * s.kt * m.sine);
    m.stretch = c_.rest + (start.slip * m.sine + stretch * m.cosine);
    return m;
  }
  const double sign = direction(segment.mode);
  const double change = sign * s.mu * (c_.normal.impulse(m.normal) - c_.normal.impulse(segment.from));
  m.friction = start.friction - change;
  m.slip = start.slip - c_.beta * change + s.along * elapsed;
  m.stretch = c_.slipping_stretch(m.normal, sign);
  if (c_.kappa > 0.0)
    m.stretch += std::exp(-c_.kappa * elapsed) * (start.stretch - c_.slipping_stretch(segment.from, sign));
  return m;
}

}  // namespace strobe::impact::detail
