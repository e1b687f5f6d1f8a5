#include <Eigen/Dense>
#include <algorithm>
#include <array>

#include "common/contact/differentiation.hpp"
#include "common/impact/ode/normal_spring.hpp"
#include "common/units/angles.hpp"
#include "tests/common/numerics/forms/forms.hpp"
#include "tests/common/numerics/forms/wide.hpp"

namespace strobe::numerics {

namespace {

/// Value and two derivatives at t of Lagrange's polynomial that is 1 at times[i] and 0 at the other three.
std::array<Wide, 3> lagrange(const std::array<double, 4>& times, std::size_t i, const Wide& t) {
  std::array<Wide, 3> roots;
  Wide denominator = 1;
  for (std::size_t k = 0, m = 0; k < 4; ++k) {
    if (k == i) continue;
    denominator *= Wide(times[i]) - times[k];
    roots[m++] = t - Wide(times[k]);
  }
  const auto& [a, b, c] = roots;
  return {a * b * c / denominator, (a * b + a * c + b * c) / denominator, 2 * (a + b + c) / denominator};
}

/// Coefficients from the normal equations in powers of the time.
Eigen::Vector4d normal_equations(const std::array<double, 4>& times, const std::array<double, 4>& values) {
  Eigen::Matrix4d design;
  for (int i = 0; i < 4; ++i)
    for (int power = 0; power < 4; ++power)
      design(i, power) = std::pow(times[static_cast<std::size_t>(i)], power);
  const Eigen::Vector4d y = Eigen::Map<const Eigen::Vector4d>(values.data());
  return (design.transpose() * design).ldlt().solve(design.transpose() * y);
}

/// Four rows determine the cubic, so that the fit is an interpolation, which can be had in 50 digits.
void cubic(std::span<const double> x, Tally& tally) {
  const double centre = x[4], width = x[5], at = centre + x[6] * width;
  const std::array<double, 4> times{centre - width, centre - 0.31 * width, centre + 0.47 * width,
                                    centre + width};
  const std::array<double, 4> values{x[0], x[1], x[2], x[3]};
  const auto fit = contact::fit_cubic(times, values);
  if (!fit) return tally.record("value", 1.0, 0.0, {});
  std::array<Wide, 3> want{0, 0, 0}, scale{0, 0, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto part = lagrange(times, i, at);
    for (std::size_t k = 0; k < 3; ++k) {
      want[k] += values[i] * part[k];
      // Between the rows a neighbour's part may vanish; the factorization sees all rows alike.
      scale[k] +=
          abs(values[i]) * std::max(Wide(abs(part[k])), Wide(1 / pow(Wide(width), static_cast<int>(k))));
    }
  }
  const Eigen::Vector4d c = normal_equations(times, values);
  compare(tally, "value", fit->value(at), c[0] + at * (c[1] + at * (c[2] + at * c[3])), want[0], scale[0]);
  compare(tally, "slope", fit->slope(at), c[1] + at * (2 * c[2] + at * 3 * c[3]), want[1], scale[1]);
  compare(tally, "curvature", fit->curvature(at), 2 * c[2] + 6 * at * c[3], want[2], scale[2]);
}

/// Kelvin–Voigt contact in units of sqrt(m/k), touchdown at speed 1: y = exp(-zeta·tau)·sin(q·tau)/q.
struct Spring {
  explicit Spring(const Wide& damping) : zeta(damping) {
    const Wide square = 1 - zeta * zeta;
    q = sqrt(abs(square));
    overdamped = square < 0;
  }
  Wide y(const Wide& tau) const {
    if (q == 0) return tau * exp(-zeta * tau);
    return exp(-zeta * tau) * (overdamped ? Wide(sinh(q * tau)) : Wide(sin(q * tau))) / q;
  }
  Wide v(const Wide& tau) const {
    const Wide cosine = q == 0 ? Wide(1) : overdamped ? Wide(cosh(q * tau)) : Wide(cos(q * tau));
    return exp(-zeta * tau) * cosine - zeta * y(tau);
  }
  /// Where the force y + 2·zeta·v vanishes; its derivative is v + 2·zeta·(-y - 2·zeta·v).
  Wide release(double near) const {
    Wide tau = near;
    for (int i = 0; i < 20; ++i) {
      const Wide force = y(tau) + 2 * zeta * v(tau);
      const Wide step = force / (v(tau) - 2 * zeta * force);
      tau -= step;
      if (abs(step) < tau * Wide(1e-40)) break;
    }
    return tau;
  }
  Wide zeta, q;
  bool overdamped;
};

void spring(std::span<const double> x, Tally& tally) {
  const double zeta = x[0];
  const Spring wide(zeta);
  const double got = impact::release_phase(zeta);
  const Wide release = wide.release(got);
  const double q = std::sqrt(std::abs(1.0 - zeta * zeta));
  const std::optional<double> plain =
      zeta < 1.0 ? std::optional((kPi - std::atan2(2.0 * zeta * q, 1.0 - 2.0 * zeta * zeta)) / q)
                 : std::nullopt;
  compare(tally, "release phase", got, plain, release, 0);
  // exp() magnifies the rounding of its argument -zeta·tau.
  const Wide e = -wide.v(release), exponent = Wide(zeta) * release;
  compare(tally, "restitution", impact::restitution_of_damping_ratio(zeta),
          plain ? std::optional(std::exp(-zeta * *plain)) : std::nullopt, e, e * (1 + exponent));
}

void spring_inverse(std::span<const double> x, Tally& tally) {
  const double e = x[0], got = *impact::damping_ratio_from_restitution(e);
  const auto restitution = [](const Wide& zeta) {
    const Spring s(zeta);
    return Wide(-s.v(s.release(impact::release_phase(static_cast<double>(zeta)))));
  };
  if (e == 1.0) return compare(tally, "damping ratio", got, {}, 0, 0);
  Wide older = got * (1 - Wide(1e-9)), old = got * (1 + Wide(1e-9));
  Wide r_older = restitution(older), r_old = restitution(old);
  const Wide slope = (r_old - r_older) / (old - older);
  for (int i = 0; i < 8 && r_old != r_older; ++i) {
    const Wide next = old - (r_old - Wide(e)) * (old - older) / (r_old - r_older);
    older = old;
    r_older = r_old;
    old = next;
    if (abs(old - older) < old * Wide(1e-36)) break;
    r_old = restitution(old);
  }
  compare(tally, "damping ratio", got, {}, old, old + (1 - e < 0.5 ? Wide(0) : Wide(abs(e / slope))));
}

}  // namespace

std::vector<Form> contact_forms() {
  const auto value = [](const char* name) { return either_sign(name, 1e-3, 10.0); };
  return {
      {"cubic through four rows",
       "sum of the rows, each with what it contributes but not less than over half_width^order",
       "orthogonal factorization in (t - centre)/half width, not normal equations in t",
       {value("y0"), value("y1"), value("y2"), value("y3"), even("centre", -0.5, 1.5),
        logarithmic("half_width", 1e-6, 1.0), even("at", -1.0, 1.0)},
       cubic},
      {"contact spring",
       "itself; e: the exponent's rounding",
       "acos and acosh over their chord, a series where they meet",
       {logarithmic("zeta", 1e-12, 15.0, {0.0, 0.5, 1.0, 0.99949, 1.0005})},
       spring},
      {"contact spring's damping",
       "itself",
       "light: its own root; heavy: x·cot(x) in x²",
       {unit_interval("e", 1e-3)},
       spring_inverse},
  };
}

}  // namespace strobe::numerics
