#include <array>

#include "common/flight/aerodynamics.hpp"
#include "common/flight/parabola.hpp"
#include "tests/common/numerics/forms/forms.hpp"
#include "tests/common/numerics/forms/wide.hpp"

namespace strobe::numerics {

namespace {

using flight::Parabola;

struct Crossing {
  Wide velocity_squared, time;
};

/// drop = v·t + a·t²/2 at the root where the velocity is sign·sqrt(v² + 2·a·drop).
Crossing crossing(const Wide& v, const Wide& a, const Wide& drop, int sign) {
  const Wide square = v * v + 2 * a * drop;
  const Wide there = square > 0 ? Wide(sign * sqrt(square)) : Wide(0);
  return {square, a == 0 ? Wide(drop / v) : Wide((there - v) / a)};
}

void parabola_times(std::span<const double> x, Tally& tally) {
  const double v = x[0], drop = x[1], g = -x[2];
  for (const int sign : {-1, 1}) {
    const Parabola path{{0.0, 0.0}, {15.0, v}, {0.0, g}};
    const auto got = sign < 0 ? path.time_falling_through_s(drop) : path.time_rising_through_s(drop);
    const Crossing want = crossing(v, g, drop, sign);
    const Wide size = Wide(v) * v + abs(2 * Wide(g) * drop);
    if (abs(want.velocity_squared) <= size * Wide(1e-12)) continue;  // touches the height or not
    const bool passes = want.velocity_squared > 0;
    tally.record("whether it passes", got.has_value() == passes ? 0.0 : 1.0, 0.0, {});
    if (!got || !passes) continue;
    Wide scale = abs(want.time);
    for (const auto& varied :
         {crossing(v * (1 + Wide(1e-13)), g, drop, sign), crossing(v, g * (1 + Wide(1e-13)), drop, sign),
          crossing(v, g, drop * (1 + Wide(1e-13)), sign)})
      scale += abs(varied.time - want.time) * Wide(1e13);
    const double textbook = (-v + sign * std::sqrt(v * v + 2.0 * g * drop)) / g;
    compare(tally, sign < 0 ? "falling through" : "rising through", *got, textbook, want.time, scale);
  }
}

void parabola_path(std::span<const double> x, Tally& tally) {
  const double v = x[0], y = x[1], g = -x[2], t = x[3];
  const Parabola path{{0.0, y}, {15.0, v}, {0.0, g}};
  const Wide fall = Wide(g) * t * t / 2, way = Wide(v) * t;
  compare(tally, "height", path.position_at(t).y(), {}, Wide(y) + way + fall,
          abs(Wide(y)) + abs(way) + abs(fall));
  compare(tally, "velocity", path.velocity_at(t).y(), {}, Wide(v) + Wide(g) * t,
          abs(Wide(v)) + abs(Wide(g) * t));
}

void gravity(std::span<const double> x, Tally& tally) {
  const Eigen::Vector2d got = flight::gravity_mps2(x[0]);
  const Wide g("9.80665");
  compare(tally, "along", got.x(), {}, -g * sin(Wide(x[0])), 0);
  compare(tally, "normal", got.y(), {}, -g * cos(Wide(x[0])), g);
}

struct WideVector {
  Wide x, y;
};

/// Gravity, drag against the motion, lift across it with C_L = 1/(2 + v/(R·|omega|)).
WideVector acceleration(const flight::Aerodynamics& air, const Eigen::Vector2d& g, const Wide& vx,
                        const Wide& vy, double omega) {
  const Wide speed = sqrt(vx * vx + vy * vy), rim = Wide(air.radius_m) * omega;
  const Wide coefficient = omega == 0.0 ? Wide(0) : Wide(1 / (2 + speed / abs(rim)) * (omega > 0.0 ? 1 : -1));
  const Wide drag = Wide(air.drag_per_m) * speed, lift = Wide(air.lift_per_m) * coefficient * speed;
  return {Wide(g.x()) - drag * vx - lift * vy, Wide(g.y()) - drag * vy + lift * vx};
}

void forcing(std::span<const double> x, Tally& tally) {
  const double angle = x[1] / 180.0 * 3.14159265358979323846;
  const Eigen::Vector2d v{x[0] * std::cos(angle), -x[0] * std::sin(angle)};
  const Eigen::Vector2d g = flight::gravity_mps2(0.1);
  const flight::Aerodynamics air = flight::aerodynamics(ball::Ball{}, flight::kAirDensity_kgpm3);
  const flight::Forcing got = flight::forcing(air, g, v, x[2]);
  const Wide speed = sqrt(Wide(v.x()) * v.x() + Wide(v.y()) * v.y()), h = speed * Wide(1e-14);
  const Wide rate = Wide(air.drag_per_m + air.lift_per_m) * speed, size = Wide(10) + rate * speed;
  const auto at = [&](const Wide& dx, const Wide& dy) {
    return acceleration(air, g, v.x() + dx, v.y() + dy, x[2]);
  };
  const WideVector a = at(0, 0);
  compare(tally, "ax", got.acceleration_mps2.x(), {}, a.x, size);
  compare(tally, "ay", got.acceleration_mps2.y(), {}, a.y, size);
  // Central differences over 1e-14 of the speed: 1e-28 of error.
  const WideVector right = at(h, 0), left = at(-h, 0), up = at(0, h), down = at(0, -h);
  const Wide xx = (right.x - left.x) / (2 * h), xy = (up.x - down.x) / (2 * h);
  const Wide yx = (right.y - left.y) / (2 * h), yy = (up.y - down.y) / (2 * h);
  const std::array<std::pair<double, Wide>, 4> slopes{{{got.by_velocity_per_s(0, 0), xx},
                                                       {got.by_velocity_per_s(0, 1), xy},
                                                       {got.by_velocity_per_s(1, 0), yx},
                                                       {got.by_velocity_per_s(1, 1), yy}}};
  for (const auto& [slope, want] : slopes) compare(tally, "slopes", slope, {}, want, rate);
  compare(tally, "jerk", got.jerk_mps3.x(), {}, xx * a.x + xy * a.y, rate * size);
  compare(tally, "jerk", got.jerk_mps3.y(), {}, yx * a.x + yy * a.y, rate * size);
}

void lift_coefficient(std::span<const double> x, Tally& tally) {
  const Wide rim = Wide(x[0]) * abs(Wide(x[1]));
  compare(tally, "C_L", flight::lift_coefficient(x[0], x[1], x[2]),
          x[1] == 0.0 ? 0.0 : 1.0 / (2.0 + x[2] / (x[0] * std::abs(x[1]))),
          rim == 0 ? Wide(0) : Wide(1 / (2 + x[2] / rim)), 0);
}

}  // namespace

std::vector<Form> flight_forms() {
  const Axis fall = either_sign("vy_mps", 1e-6, 1e3);
  const Axis height = either_sign("drop_m", 1e-9, 10.0);
  const Axis pull = logarithmic("g_mps2", 1e-6, 10.0, {9.80665});
  return {
      {"time at a height",
       "itself and what 1e-13 of an argument changes",
       "of the two forms of the root the one without cancellation",
       {fall, height, pull},
       parabola_times},
      {"parabola",
       "the terms of the sum",
       "",
       {fall, height, pull, either_sign("t_s", 1e-6, 1.0)},
       parabola_path},
      {"gravity", "along: itself; normal: g", "", {either_sign("inclination_rad", 1e-9, 1.5707)}, gravity},
      {"drag and lift",
       "the terms of the sum",
       "",
       {logarithmic("speed_mps", 1e-6, 1e3), logarithmic("angle_deg", 0.01, 90.0),
        either_sign("omega_radps", 1e-3, 1e5)},
       forcing},
      {"lift coefficient",
       "itself",
       "R·omega multiplied out",
       {logarithmic("radius_m", 1e-3, 1.0), either_sign("omega_radps", 1e-3, 1e5),
        logarithmic("speed_mps", 1e-6, 1e3)},
       lift_coefficient},
  };
}

}  // namespace strobe::numerics
