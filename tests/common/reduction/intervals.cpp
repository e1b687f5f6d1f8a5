#include "tests/common/reduction/intervals.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace strobe::test {

using reduction::kPrimaryCount;
using reduction::Quantities;
using reduction::Quantity;

namespace {

constexpr double kOneSigma = 0.6826894921370859;
constexpr double kTwoSigma = 0.9544997361036416;
constexpr std::size_t kSteps = 200;

struct Table {
  std::array<double, kSteps> factor{};  // falls with nu
  std::array<double, kSteps> widening{};
};

Table make_table() {
  Table table;
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double nu = 0.8 * std::pow(1e4, static_cast<double>(i) / (kSteps - 1));
    const boost::math::students_t distribution(nu);
    table.factor[i] = quantile(distribution, 0.5 + 0.5 * kOneSigma);
    table.widening[i] = quantile(distribution, 0.5 + 0.5 * kTwoSigma) / table.factor[i];
  }
  return table;
}

}  // namespace

Quantities plain_sd(const reduction::Readout& r) {
  Quantities sd;
  if (!r.covariance) return sd;
  const auto of = [&](const std::array<double, kPrimaryCount>& slope) {
    double sum = 0.0;
    for (std::size_t i = 0; i < kPrimaryCount; ++i)
      for (std::size_t k = 0; k < kPrimaryCount; ++k) sum += slope[i] * (*r.covariance)[i][k] * slope[k];
    return std::sqrt(sum);
  };
  const double vx_td = *r.value[Quantity::vx_td_mps], vy_td = *r.value[Quantity::vy_td_mps];
  const double vx_lo = *r.value[Quantity::vx_lo_mps], vy_lo = *r.value[Quantity::vy_lo_mps];
  const double impulse = vy_lo - vy_td, mu = (vx_td - vx_lo) / impulse;
  sd[Quantity::vx_td_mps] = of({1});
  sd[Quantity::vy_td_mps] = of({0, 1});
  sd[Quantity::omega_td_radps] = of({0, 0, 1});
  sd[Quantity::vx_lo_mps] = of({0, 0, 0, 0, 1});
  sd[Quantity::vy_lo_mps] = of({0, 0, 0, 0, 0, 1});
  sd[Quantity::omega_lo_radps] = of({0, 0, 0, 0, 0, 0, 1});
  sd[Quantity::e] = of({0, vy_lo / (vy_td * vy_td), 0, 0, 0, -1 / vy_td});
  sd[Quantity::mu] = of({1 / impulse, mu / impulse, 0, 0, -1 / impulse, -mu / impulse});
  sd[Quantity::dwell_time_ms] = 1e3 * of({0, 0, 0, -1, 0, 0, 0, 1});
  return sd;
}

double widening(double factor) {
  static const Table table = make_table();
  std::size_t i = 1;
  while (i + 1 < kSteps && table.factor[i] > factor) ++i;
  const double share = (factor - table.factor[i - 1]) / (table.factor[i] - table.factor[i - 1]);
  return table.widening[i - 1] + std::min(1.0, share) * (table.widening[i] - table.widening[i - 1]);
}

}  // namespace strobe::test
