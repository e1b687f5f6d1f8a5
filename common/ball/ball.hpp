// A tennis ball as the models see it: size, mass, moment of inertia. Units: m, kg, kg·m². Plain values and
// pure functions: thread-safe, real-time safe. Inputs are preconditions unless a Result is returned.
#pragma once

#include "common/result.hpp"

namespace strobe::ball {

/// Working values of the thesis: the mean of its balls, and the diameter every speed was scaled with.
inline constexpr double kThesisDiameter_m = 0.0651;
inline constexpr double kThesisMass_kg = 0.0576;

/// I = alpha·m·R². A thin shell at the outer radius (the thesis's equations) and the value measured on tennis
/// balls by R. Cross.
inline constexpr double kThinShellAlpha = 2.0 / 3.0;
inline constexpr double kMeasuredAlpha = 0.55;
/// How well a ball's alpha is known that was not measured itself. A shell of rubber alone, without the felt,
/// has 0.508: a ball is somewhere within that 0.042 of the measured value, either way (uniform: a root of 3
/// less).
inline constexpr double kAlphaSd = 0.024;

/// The rubber shell of the thesis's balls: outer and inner radius, and their mean.
inline constexpr double kShellOuterRadius_m = 0.0300;
inline constexpr double kShellInnerRadius_m = 0.0268;
inline constexpr double kShellMeanRadius_m = 0.0284;

/// Sizes and masses beyond these are refused: no power of them that the models form overflows.
inline constexpr double kMinSize = 1e-30;
inline constexpr double kMaxSize = 1e30;

/// One ball. `alpha` is the moment of inertia over m·R², R being half of `diameter_m`.
/// Valid: diameter_m > 0, mass_kg > 0, 0 < alpha <= 2/3 (no mass lies outside the surface); see check().
struct Ball {
  double diameter_m = kThesisDiameter_m;
  double mass_kg = kThesisMass_kg;
  double alpha = kMeasuredAlpha;

  constexpr double radius_m() const { return diameter_m / 2.0; }
  constexpr double inertia_kgm2() const { return alpha * mass_kg * radius_m() * radius_m(); }
};

/// The ball itself, or what is wrong with it (non-finite or out of the ranges above).
Result<Ball> check(const Ball& ball);

/// Moment of inertia of a thin spherical shell, (2/3)·m·r².
constexpr double thin_shell_inertia_kgm2(double mass_kg, double shell_radius_m) {
  return kThinShellAlpha * mass_kg * shell_radius_m * shell_radius_m;
}

/// Moment of inertia of a thick spherical shell, (2m/5)(a⁵-b⁵)/(a³-b³), with the common factor a-b divided
/// out so that thin shells lose no digits. Valid: outer > 0, 0 <= inner <= outer, mass > 0; otherwise a
/// message.
Result<double> thick_shell_inertia_kgm2(double mass_kg, double outer_radius_m, double inner_radius_m);

}  // namespace strobe::ball
