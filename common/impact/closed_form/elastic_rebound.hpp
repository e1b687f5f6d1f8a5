// Oblique rebound of a stiff elastic ball, piecewise in closed form: the model of Maw, Barber and Fawcett
// with the footprint's tractions lumped into one tangential spring that grips and slips as a whole.
//
// Their own solution follows stick and slip annulus by annulus and has no closed form. Lumped, and with the
// normal spring linear, all motion between changes of grip and slip is circular functions of time. In units
// of |vy|, the ball's mass and the spring's quarter period of compression, with w = (vx + R·omega)/|vy|,
// kappa = k_t/k, beta = 1 + 1/alpha:
//   normal force  n = sin(t) while it is compressed, cos((t - pi/2)/e) while it expands (impulse 1 + e),
//   dw/dt = -beta·f;   grips: df/dt = kappa·w;   slips: f = sigma·mu·n.
// It has the limits of theirs: with psi1 = kappa·w/mu and chi = kappa·beta/2 the ball grips from touchdown on
// where psi1 < 1, and at e = 1 slides throughout where psi1 > 4·chi - 1. Below that vx differs from the whole
// footprint's by up to 0.11·mu·|vy| (near psi1 = 1; psi2 = kappa·w_LO/mu by 0.37·kappa), by less than 0.02 of
// it above psi1 = 2.5: `strobe-bench bounces`.
//
// Valid: bodies that stay elastic, with footprints small against their radius and contacts long against the
// time in which waves cross the ball (metal, glass, ceramics, solid rubber at some m/s); no offset of the
// normal force; isotropic friction, static as sliding. Not for hollow or felted balls, nor for soft ground. e
// below 1 takes normal energy by the spring's own hysteresis, independent of friction.
//
// Pure, no allocation: thread-safe, real-time safe. Slips to 1e-10 of that at touchdown, some µs a
// rebound. Sources: N. Maw, J. R. Barber, J. N. Fawcett, The oblique impact of
// elastic spheres, Wear 38 (1976); W. J. Stronge, Impact Mechanics (2000), on lumped compliance; R. D.
// Mindlin, Compliance of elastic bodies in contact, 1949. The articles themselves could not be read; the
// equations are derived anew, and held against a numerical solution of the whole footprint.
#pragma once

#include <tl/expected.hpp>

#include "common/impact/closed_form/rebound.hpp"

namespace strobe::impact {

/// k_t/k of elastic bodies without slip at small displacements (Mindlin): ball and surface of Poisson's
/// ratios nu and nu_surface, 0…0.5, whose shear moduli have the ratio G_surface/G > 0. Of one material 2(1 -
/// nu)/(2 - nu).
constexpr double mindlin_stiffness_ratio(double nu, double nu_surface, double shear_ratio) {
  return ((1.0 - nu) * shear_ratio + (1.0 - nu_surface)) /
         ((1.0 - nu / 2.0) * shear_ratio + (1.0 - nu_surface / 2.0));
}
constexpr double mindlin_stiffness_ratio(double nu) { return mindlin_stiffness_ratio(nu, nu, 1.0); }

/// Range of k_t/k, as of the contact mechanics.
inline constexpr double kMinStiffnessRatio = 1e-3;
inline constexpr double kMaxStiffnessRatio = 1e3;

struct ElasticCoefficients {
  double e = 1.0;                                         ///< normal restitution, 0…1
  double mu = 0.0;                                        ///< coefficient of friction, >= 0
  double stiffness_ratio = mindlin_stiffness_ratio(0.3);  ///< kappa
};

/// Regime: slides where the contact never grips. Errors: those of rigid(); spring_out_of_range.
tl::expected<Rebound, InputError> elastic_rebound(const ball::Ball& ball, const Motion& touchdown,
                                                  const ElasticCoefficients& coefficients);

}  // namespace strobe::impact
