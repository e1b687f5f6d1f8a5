#include "host/thesis/tables/tolerance.hpp"

#include <algorithm>
#include <cmath>

#include "common/units/angles.hpp"

namespace strobe::report {

namespace {

struct Curvature {
  double xx, xy, yy;
};

/// The largest |½ tr(H·Σ)| over correlations -1…1.
double second_order(const Curvature& h, double sd_x, double sd_y) {
  const double own = h.xx * sd_x * sd_x + h.yy * sd_y * sd_y;
  const double mixed = 2.0 * h.xy * sd_x * sd_y;
  return 0.5 * std::max(std::abs(own + mixed), std::abs(own - mixed));
}

/// a/b of two means.
DerivedValue ratio(double a, double sd_a, double half_a, double b, double sd_b, double half_b) {
  const double value = a / b;
  const double rounding = (half_a + std::abs(value) * half_b) / std::abs(b);
  const Curvature h{0.0, -1.0 / (b * b), 2.0 * a / (b * b * b)};
  return {value, {rounding, second_order(h, sd_a, sd_b)}};
}

}  // namespace

DerivedValue angle_deg(const thesis::MeanSd& vx, const thesis::MeanSd& vy) {
  const double x = vx.mean;
  const double y = vy.mean;
  const double squared = x * x + y * y;
  const double fourth = squared * squared;
  const Curvature h{2.0 * x * y / fourth, (y * y - x * x) / fourth, -2.0 * x * y / fourth};
  const double rounding = kHalfDigit * (std::abs(x) + std::abs(y)) / squared;
  return {degrees(std::atan2(y, x)), {degrees(rounding), degrees(second_order(h, vx.sd, vy.sd))}};
}

DerivedValue speed(const thesis::MeanSd& vx, const thesis::MeanSd& vy) {
  const double x = vx.mean;
  const double y = vy.mean;
  const double v = std::hypot(x, y);
  const double cubed = v * v * v;
  const Curvature h{y * y / cubed, -x * y / cubed, x * x / cubed};
  return {v, {kHalfDigit * (std::abs(x) + std::abs(y)) / v, second_order(h, vx.sd, vy.sd)}};
}

DerivedValue restitution(const thesis::Condition& c) {
  return ratio(c.vy_lo_mps.mean, c.vy_lo_mps.sd, kHalfDigit, -c.vy_td_mps.mean, c.vy_td_mps.sd, kHalfDigit);
}

DerivedValue impulse_ratio(const thesis::Condition& c) {
  return ratio(c.vx_td_mps.mean - c.vx_lo_mps.mean, c.vx_td_mps.sd + c.vx_lo_mps.sd, 2.0 * kHalfDigit,
               c.vy_lo_mps.mean - c.vy_td_mps.mean, c.vy_lo_mps.sd + c.vy_td_mps.sd, 2.0 * kHalfDigit);
}

DerivedValue angle_sd_deg(const thesis::MeanSd& vx, const thesis::MeanSd& vy, const thesis::MeanSd& v) {
  const double left = vx.sd * vx.sd + vy.sd * vy.sd - v.sd * v.sd;
  const double slack = 2.0 * kHalfDigit * (vx.sd + vy.sd + v.sd);
  const double speed = std::hypot(vx.mean, vy.mean);
  const auto sd = [speed](double variance) { return degrees(std::sqrt(std::max(0.0, variance)) / speed); };
  const double value = sd(left);
  const double rounding = std::max(sd(left + slack) - value, value - sd(left - slack));
  const double relative = (vx.sd * vx.sd + vy.sd * vy.sd) / (speed * speed);
  return {value, {rounding, 4.0 * relative * value}};
}

}  // namespace strobe::report
