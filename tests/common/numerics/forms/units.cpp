#include "common/ball/ball.hpp"
#include "common/units/angles.hpp"
#include "tests/common/numerics/forms/forms.hpp"
#include "tests/common/numerics/forms/wide.hpp"

namespace strobe::numerics {

namespace {

/// Mass of the shell's layers times (2/3)·r², summed: the quotient of the moments of r⁴ and r². A shell of no
/// thickness is the limit (2/3)·m·a².
void thick_shell(std::span<const double> x, Tally& tally) {
  const double mass = x[0], outer = x[1], inner = std::min(outer * (1.0 - x[2]), outer);
  const Wide a = outer, b = inner;
  const Wide want = a == b
                        ? Wide(2) / 3 * mass * a * a
                        : Wide(2) / 3 * mass * ((pow(a, 5) - pow(b, 5)) / 5) / ((pow(a, 3) - pow(b, 3)) / 3);
  const double textbook =
      0.4 * mass * (std::pow(outer, 5) - std::pow(inner, 5)) / (std::pow(outer, 3) - std::pow(inner, 3));
  compare(tally, "inertia", *ball::thick_shell_inertia_kgm2(mass, outer, inner), textbook, want, 0);
}

void ball_values(std::span<const double> x, Tally& tally) {
  const ball::Ball ball{x[0], x[1], x[2]};
  const Wide radius = Wide(x[0]) / 2;
  compare(tally, "inertia", ball.inertia_kgm2(), {}, Wide(x[2]) * x[1] * radius * radius, 0);
  compare(tally, "thin shell", ball::thin_shell_inertia_kgm2(x[1], x[0] / 2), {},
          Wide(2) / 3 * x[1] * radius * radius, 0);
}

void wrapping(std::span<const double> x, Tally& tally) {
  // Turns of either sign plus a rest that may be tiny, so that the result passes close by zero.
  const double angle = std::round(x[0]) * kPi + x[1];
  const double got = wrap_half_turn(angle);
  const Wide period = wide_pi();
  Wide want = Wide(angle) - period * round(Wide(angle) / period);
  // Within an ulp of half a period either end is right.
  if (abs(abs(want) - period / 2) < Wide(1e-15) && want * got < 0)
    want = want > 0 ? want - period : want + period;
  compare(tally, "half turn", got, angle - kPi * std::nearbyint(angle / kPi), want, Wide(1e-11));
}

void degrees_and_back(std::span<const double> x, Tally& tally) {
  compare(tally, "radians", radians(x[0]), {}, Wide(x[0]) * wide_pi() / 180, 0);
  compare(tally, "degrees", degrees(x[0]), {}, Wide(x[0]) * 180 / wide_pi(), 0);
}

}  // namespace

std::vector<Form> unit_forms() {
  return {
      {"thick shell",
       "itself",
       "common factor a - b divided out",
       {logarithmic("mass_kg", 1e-3, 1e3), logarithmic("outer_m", 1e-3, 10.0),
        unit_interval("thickness/outer")},
       thick_shell},
      {"ball",
       "itself",
       "",
       {logarithmic("diameter_m", 1e-3, 10.0), logarithmic("mass_kg", 1e-3, 1e3),
        logarithmic("alpha", 1e-3, 0.66)},
       ball_values},
      {"wrap",
       "itself, not less than 1e-11 rad",
       "pi in two parts, products that do not round (fma)",
       {either_sign("half_turns", 1.0, 3e7), either_sign("rest_rad", 1e-12, 1.5)},
       wrapping},
      {"degrees", "itself", "", {either_sign("angle", 1e-12, 1e9, {90.0, 0.01, 180.0})}, degrees_and_back},
  };
}

}  // namespace strobe::numerics
