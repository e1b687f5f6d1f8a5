#include "common/flight/vertical.hpp"

#include <cmath>
#include <limits>

namespace strobe::flight {
namespace {

// Below this the series' first left out term, some x^3, is under 1e-15 of the sum, above it the closed form
// loses less than 1e-11 of a derivative to cancellation.
constexpr double kSmall = 1e-5;

/// ln(1 + x)/x and its derivative, x > -1.
struct Shape {
  double value, slope;
};
Shape logarithm_share(double x) {
  if (std::abs(x) < kSmall) return {1.0 - x / 2.0 + x * x / 3.0, -0.5 + 2.0 * x / 3.0 - 0.75 * x * x};
  const double value = std::log1p(x) / x;
  return {value, (1.0 / (1.0 + x) - value) / x};
}

/// (exp(y) - 1)/y and its derivative, any y.
Shape exponential_share(double y) {
  if (std::abs(y) < kSmall) return {1.0 + y / 2.0 + y * y / 6.0, 0.5 + y / 3.0 + y * y / 8.0};
  const double value = std::expm1(y) / y;
  return {value, (std::exp(y) - value) / y};
}

/// speed^2 = 2 g h (exp(y) - 1)/y with y = 2 k h, upwards; with y = -2 k h downwards.
VerticalNumber speed_mps(double height_m, double drag_per_m, double gravity_mps2, double sign) {
  const double y = sign * 2.0 * drag_per_m * height_m;
  const Shape share = exponential_share(y);
  const double speed = std::sqrt(2.0 * gravity_mps2 * height_m * share.value);
  if (!(speed > 0.0)) return {};
  const double by_share = gravity_mps2 * height_m / speed;
  return {speed, gravity_mps2 * std::exp(y) / speed, by_share * share.slope * sign * 2.0 * height_m};
}

}  // namespace

VerticalNumber rise_m(double speed_mps, double drag_per_m, double gravity_mps2) {
  const double square = speed_mps * speed_mps / gravity_mps2;
  const double x = drag_per_m * square;
  const Shape share = logarithm_share(x);
  return {0.5 * square * share.value, speed_mps / (gravity_mps2 * (1.0 + x)),
          0.5 * square * square * share.slope};
}

VerticalNumber fall_m(double speed_mps, double drag_per_m, double gravity_mps2) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (drag_per_m * speed_mps * speed_mps >= gravity_mps2) return {kNever, kNever, kNever};
  VerticalNumber height = rise_m(speed_mps, -drag_per_m, gravity_mps2);
  height.by_drag_per_m = -height.by_drag_per_m;
  return height;
}

VerticalNumber rise_speed_mps(double height_m, double drag_per_m, double gravity_mps2) {
  return speed_mps(height_m, drag_per_m, gravity_mps2, 1.0);
}

VerticalNumber fall_speed_mps(double height_m, double drag_per_m, double gravity_mps2) {
  return speed_mps(height_m, drag_per_m, gravity_mps2, -1.0);
}

}  // namespace strobe::flight
