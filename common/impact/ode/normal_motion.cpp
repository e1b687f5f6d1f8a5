#include "common/impact/ode/normal_motion.hpp"

#include <algorithm>
#include <numbers>

#include "common/impact/ode/normal_spring.hpp"

namespace strobe::impact::detail {

namespace {

// Beyond it the next zero of y is so late that the time from touchdown is a square of x alone.
constexpr double kHeavyDamping = 0.95;

/// x with x²(3 - 2x) = share.
double smooth_step_inverse(double share) {
  if (share >= 1.0) return 1.0;
  double x = 0.5 - std::sin(std::asin(1.0 - 2.0 * share) / 3.0);
  // The sine's argument has lost what 1 - 2·share rounded off: near 0 the root of it.
  for (int i = 0; i < 2; ++i) {
    const double slope = 6.0 * x * (1.0 - x);
    if (slope > 0.0) x -= (x * x * (3.0 - 2.0 * x) - share) / slope;
  }
  return std::clamp(x, 0.0, 1.0);
}

}  // namespace

bool NormalMotion::settle(double& tau, bool of_force) const {
  for (int i = 0; i < 12; ++i) {
    const NormalState n = at(tau);
    const double slope = of_force ? force_rate(n) : n.rate;
    if (!(slope < 0.0)) return false;
    const double step = (of_force ? force(n) : n.depth) / slope;
    tau -= step;
    if (!(std::abs(step) < 0.5)) return false;
    if (std::abs(step) <= 4e-16 * tau) return true;
    if (i > 4 && std::abs(step) <= 1e-14 * tau) return true;
  }
  return false;
}

std::optional<NormalMotion> NormalMotion::make(const System& s) {
  NormalMotion m;
  m.zeta_ = s.zeta;
  m.gravity_ = s.gravity;
  m.omega2_ = (1.0 - s.zeta) * (1.0 + s.zeta);
  m.release_ = release_phase(s.zeta);
  m.smooth_ = s.zeta < kHeavyDamping;
  m.span_ = m.smooth_ ? std::numbers::pi / std::sqrt(m.omega2_) : m.release_;
  if (s.gravity != 0.0) {
    if (!m.settle(m.release_, true)) return std::nullopt;
    if (m.smooth_ && !m.settle(m.span_, false)) return std::nullopt;
    if (!m.smooth_) m.span_ = m.release_;
  }
  m.square_ = m.smooth_ ? 3.0 * m.span_ : m.span_;
  m.cube_ = m.smooth_ ? 2.0 * m.span_ : 0.0;
  m.end_ = m.smooth_ ? smooth_step_inverse(m.release_ / m.span_) : 1.0;
  m.by_series_ = std::abs(m.omega2_) * m.release_ * m.release_ <= kMaxSeriesPhase2;
  return m;
}

double NormalMotion::x_of(double tau) const {
  return smooth_ ? smooth_step_inverse(tau / span_) : std::sqrt(tau / span_);
}

double NormalMotion::passes(double depth, double tau) const {
  for (int i = 0; i < 60; ++i) {
    const NormalState n = at(tau);
    const double step = (n.depth - depth) / n.rate;
    tau -= step;
    if (std::abs(step) <= 1e-15 * tau) break;
  }
  return tau;
}

double NormalMotion::first_turn(double cosine, double sine) const {
  // cosine·C + sine·S = 0, cosine > 0.
  const double q = std::sqrt(std::abs(omega2_));
  if (q < 1e-7) return -cosine / sine;
  if (omega2_ > 0.0) return std::atan2(q * cosine, -sine) / q;
  return std::atanh(q * cosine / -sine) / q;
}

double NormalMotion::deepest_tau() const {
  const double tau = first_turn(1.0, gravity_ - zeta_);
  return tau >= 0.0 && tau < release_ ? tau : release_;
}

double NormalMotion::largest_force_tau() const {
  const double cosine = 1.0 + 2.0 * zeta_ * (gravity_ - 2.0 * zeta_);
  if (!(cosine > 0.0)) return 0.0;
  return first_turn(cosine, gravity_ - zeta_ * (3.0 + 2.0 * zeta_ * (gravity_ - 2.0 * zeta_)));
}

}  // namespace strobe::impact::detail
