// The bounce with grip, tangential restitution and offset normal force from its balances, as an independent
// reference: three linear equations for (vx_LO, omega_LO, friction impulse per mass) in extended precision,
// with the friction impulse's limit in place of the grip's equation where gripping would need more.
// No account is taken of energy: the caller keeps to offsets that take energy away.
#pragma once

#include <array>
#include <cmath>
#include <utility>

namespace strobe::testing {

struct BalanceInput {
  long double vx, vy, omega, e;
  long double mu, e_x, offset_m, reference_mps, alpha, radius_m;
};

struct BalanceOutput {
  long double vx = 0, omega = 0, friction = 0;
  bool gripped = false;
};

/// Gauss elimination with row pivoting; the matrix with its right-hand side as the last column.
inline std::array<long double, 3> solve(std::array<std::array<long double, 4>, 3> m) {
  for (std::size_t c = 0; c < 3; ++c) {
    std::size_t pivot = c;
    for (std::size_t r = c + 1; r < 3; ++r)
      if (std::fabs(m[r][c]) > std::fabs(m[pivot][c])) pivot = r;
    std::swap(m[c], m[pivot]);
    for (std::size_t r = 0; r < 3; ++r) {
      if (r == c) continue;
      const long double factor = m[r][c] / m[c][c];
      for (std::size_t k = c; k < 4; ++k) m[r][k] -= factor * m[c][k];
    }
  }
  return {m[0][3] / m[0][0], m[1][3] / m[1][1], m[2][3] / m[2][2]};
}

inline BalanceOutput bounce(const BalanceInput& in) {
  const long double normal = (1 + in.e) * -in.vy;
  const long double rolling = (in.vx - in.radius_m * in.omega) / 2;
  const long double offset =
      in.offset_m * rolling / std::sqrt(rolling * rolling + in.reference_mps * in.reference_mps);
  const long double inertia = in.alpha * in.radius_m * in.radius_m;
  using Row = std::array<long double, 4>;
  const Row momentum{1, 0, -1, in.vx};
  const Row turning{0, inertia, -in.radius_m, inertia * in.omega + offset * normal};
  const Row grip{1, in.radius_m, 0, -in.e_x * (in.vx + in.radius_m * in.omega)};
  BalanceOutput out;
  auto x = solve({momentum, turning, grip});
  out.gripped = std::fabs(x[2]) <= in.mu * normal;
  if (!out.gripped) {
    const Row limit{0, 0, 1, std::copysign(in.mu * normal, x[2])};
    x = solve({momentum, turning, limit});
  }
  out.vx = x[0];
  out.omega = x[1];
  out.friction = x[2];
  return out;
}

}  // namespace strobe::testing
