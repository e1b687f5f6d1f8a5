#include "common/impact/closed_form/elastic_rebound.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace strobe::impact {

namespace {

constexpr double kQuarter = std::numbers::pi / 2.0;

/// Compression or expansion of the normal spring in its own phase x, 0…pi/2, in which time runs `rate` times
/// as fast.
struct Half {
  bool compresses = true;
  double rate = 1.0;

  double force(double x) const { return compresses ? std::sin(x) : std::cos(x); }
  double slope(double x) const { return compresses ? std::cos(x) : -std::sin(x); }
  double impulse(double from, double to) const {
    return compresses ? std::cos(from) - std::cos(to) : std::sin(to) - std::sin(from);
  }
};

/// At one instant of a half; sigma 0: grips.
struct State {
  double w = 0.0;
  double f = 0.0;
  int sigma = 0;
};

/// Equations of one half, in its phase.
struct Law {
  Half half;
  double mu = 0.0;
  double kappa = 0.0;  ///< times the half's rate
  double beta = 0.0;   ///< likewise

  double frequency() const { return std::sqrt(kappa * beta); }
};

/// Where a slip from x on comes to a stop in its spring: sigma·kappa·w - mu·n' = 0, which has one root at
/// most, and only where the spring is stiff enough. pi/2 if there is none.
double end_of_slip(const Law& law, const State& at, double x) {
  const double q = law.kappa * law.beta;
  if (!(law.mu > 0.0) || q <= 1.0) return kQuarter;
  const double begin = at.sigma * law.kappa * at.w / law.mu;
  const double value =
      law.half.compresses ? (q * std::cos(x) - begin) / (q - 1.0) : (q * std::sin(x) + begin) / (q - 1.0);
  if (std::abs(value) > 1.0) return kQuarter;
  return std::clamp(law.half.compresses ? std::acos(value) : std::asin(value), x, kQuarter);
}

State slipped(const Law& law, const State& at, double from, double to) {
  return {at.w - law.beta * at.sigma * law.mu * law.half.impulse(from, to),
          at.sigma * law.mu * law.half.force(to), at.sigma};
}

State gripped(const Law& law, const State& at, double dx) {
  const double frequency = law.frequency();
  const double c = std::cos(frequency * dx), s = std::sin(frequency * dx);
  return {at.w * c - at.f * frequency / law.kappa * s, at.f * c + law.kappa * at.w / frequency * s, 0};
}

/// What is left of friction's limit in a direction after dx of grip, and its derivative.
struct Margin {
  double value = 0.0;
  double slope = 0.0;
};

Margin margin_of(const Law& law, const State& begin, double x, double dx, int direction) {
  const State now = gripped(law, begin, dx);
  return {law.mu * law.half.force(x + dx) - direction * now.f,
          law.mu * law.half.slope(x + dx) - direction * law.kappa * now.w};
}

/// How far a margin certainly lasts: no parabola of the largest curvature falls faster.
double lasts(const Margin& m, double curvature) {
  const double value = std::max(0.0, m.value);
  const double root = std::sqrt(m.slope * m.slope + 2.0 * curvature * value);
  return m.slope < 0.0 ? 2.0 * value / (root - m.slope) : (m.slope + root) / curvature;
}

/// Length of the grip that begins at x: the first root of either margin, to which no step leads beyond.
/// `came` is the direction of the slip before it, whose margin begins as a double root; its third derivative
/// bounds the way over that.
double length_of_grip(const Law& law, const State& begin, double x, int came, int& direction) {
  constexpr int kMaxSteps = 2000;
  const double frequency = law.frequency();
  const double amplitude = std::hypot(begin.f, law.kappa * begin.w / frequency);
  const double curvature = law.mu + frequency * frequency * amplitude;
  const double end = kQuarter - x;
  double dx = 0.0;
  if (came != 0) {
    const double bend = law.mu * law.half.force(x) * (frequency * frequency - 1.0);
    const double over = 1.5 * bend / (curvature + frequency * frequency * frequency * amplitude);
    dx = std::min({end, over, lasts(margin_of(law, begin, x, 0.0, -came), curvature)});
  }
  for (int i = 0; i < kMaxSteps && dx < end; ++i) {
    double step = end;
    for (const int way : {-1, 1}) {
      const double safe = lasts(margin_of(law, begin, x, dx, way), curvature);
      if (safe < step) {
        step = safe;
        direction = way;
      }
    }
    if (step <= 1e-15) return dx;
    dx += step;
  }
  return std::min(dx, end);
}

/// Through one half; whether the contact gripped in it.
bool pass(const Law& law, State& state) {
  constexpr int kMaxChanges = 1000;  // of grip and slip; a very stiff tangential spring makes some 60
  double x = 0.0;
  int came = 0;
  bool grips = false;
  for (int i = 0; i < kMaxChanges && x < kQuarter; ++i) {
    if (state.sigma != 0) {
      const double end = end_of_slip(law, state, x);
      came = state.sigma;
      state = slipped(law, state, x, end);
      x = end;
      if (x < kQuarter) state.sigma = 0;
      continue;
    }
    grips = true;
    int direction = 0;
    const double length = length_of_grip(law, state, x, came, direction);
    state = gripped(law, state, length);
    x += length;
    came = 0;
    if (x < kQuarter) state.sigma = direction;
  }
  if (x < kQuarter) state = gripped(law, state, kQuarter - x);
  return grips;
}

}  // namespace

tl::expected<Rebound, InputError> elastic_rebound(const ball::Ball& ball, const Motion& touchdown,
                                                  const ElasticCoefficients& c) {
  auto out = rigid(ball, touchdown, c.e, c.mu);
  if (!out) return out;
  if (!(c.stiffness_ratio >= kMinStiffnessRatio && c.stiffness_ratio <= kMaxStiffnessRatio))
    return tl::unexpected(InputError::spring_out_of_range);
  const double radius = ball.diameter_m / 2.0;
  const double approach = -touchdown.vy_mps;
  const double slip = touchdown.vx_mps + radius * touchdown.omega_radps;
  const double beta = 1.0 + 1.0 / ball.alpha;

  State state{.w = slip / approach};
  if (std::abs(c.stiffness_ratio * state.w) >= c.mu) state.sigma = slip < 0.0 ? -1 : 1;
  bool grips = false;
  for (const Half half : std::array{Half{true, 1.0}, Half{false, c.e}})
    if (half.rate > 0.0) grips |= pass({half, c.mu, c.stiffness_ratio * half.rate, beta * half.rate}, state);

  const double dvx = (state.w * approach - slip) / beta;
  out->lift_off.vx_mps = touchdown.vx_mps + dvx;
  out->lift_off.omega_radps = touchdown.omega_radps + dvx / ball.alpha / radius;
  out->regime = grips ? Regime::grips : Regime::slides;
  out->slip_lo_mps = state.w * approach;
  out->impulse_ratio = (0.0 - dvx) / ((1.0 + c.e) * approach);
  return out;
}

}  // namespace strobe::impact
