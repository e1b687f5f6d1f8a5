#include "common/impact/ode/normal_motion.hpp"

#include <algorithm>
#include <array>
#include <numbers>

#include "common/impact/ode/normal_spring.hpp"

namespace strobe::impact::detail {

namespace {

// Beyond it the next zero of y is so late that the time from touchdown is a square of x alone.
constexpr double kHeavyDamping = 0.95;

/// x with x²(3 - 2x) = share, 1 - rest.
double smooth_step_inverse(double share, double rest) {
  if (!(share > 0.0)) return 0.0;
  if (!(rest > 0.0)) return 1.0;
  // Of the smaller half, to 3e-5 by a fit in the root of it; each step of Newton's method squares that.
  const bool low = share <= 0.5;
  const double part = low ? share : rest;
  const double r = std::sqrt(part / 3.0);
  constexpr std::array<double, 6> fit{0.999978937046, 0.336799264938, 0.187462381596,
                                      1.12436467102,  -2.82769573401, 5.11752714908};
  double x = 0.0;
  for (std::size_t k = fit.size(); k-- > 0;) x = fit[k] + x * r;
  x *= r;
  for (int i = 0; i < 2; ++i) x -= (x * x * (3.0 - 2.0 * x) - part) / (6.0 * x * (1.0 - x));
  return low ? x : 1.0 - x;
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
  m.release_ = s.release_phase;
  m.smooth_ = s.zeta < kHeavyDamping;
  m.span_ = m.smooth_ ? std::numbers::pi / std::sqrt(m.omega2_) : m.release_;
  if (s.gravity != 0.0) {
    if (!m.settle(m.release_, true)) return std::nullopt;
    if (m.smooth_ && !m.settle(m.span_, false)) return std::nullopt;
    if (!m.smooth_) m.span_ = m.release_;
  }
  m.square_ = m.smooth_ ? 3.0 * m.span_ : m.span_;
  m.cube_ = m.smooth_ ? 2.0 * m.span_ : 0.0;
  m.end_ = m.smooth_ ? smooth_step_inverse(m.release_ / m.span_, (m.span_ - m.release_) / m.span_) : 1.0;
  return m;
}

double NormalMotion::x_of(double tau) const {
  return smooth_ ? smooth_step_inverse(tau / span_, (span_ - tau) / span_) : std::sqrt(tau / span_);
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
