#include "host/series/sequential.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "host/series/sample_size.hpp"

namespace strobe::host {
namespace {

struct Inflation {
  int n;
  double more;  ///< than 1
};

/// Chosen for an even coverage: `strobe-bench series-coverage --how-many` computes it of these numbers.
/// Between them it is linear in the logarithm of n, beyond the last one inverse to n.
constexpr std::array<Inflation, 9> kInflations{{{kMinSequentialShots, 0.019},
                                                {8, 0.277},
                                                {11, 0.303},
                                                {17, 0.180},
                                                {25, 0.099},
                                                {38, 0.068},
                                                {57, 0.040},
                                                {85, 0.028},
                                                {128, 0.019}}};

}  // namespace

double sequential_inflation(int n) {
  if (n < kMinSequentialShots) return 1.0;
  const Inflation& last = kInflations.back();
  if (n >= last.n) return 1.0 + last.more * last.n / n;
  const auto above = std::ranges::upper_bound(kInflations, n, {}, &Inflation::n);
  const Inflation &b = *above, &a = *std::prev(above);
  const double part = std::log(static_cast<double>(n) / a.n) / std::log(static_cast<double>(b.n) / a.n);
  return 1.0 + a.more + part * (b.more - a.more);
}

double sequential_half_width(double scatter_sd, double shared_sd, int n) {
  return mean_half_width(sequential_inflation(n) * scatter_sd, shared_sd, n);
}

namespace {

int further_shots(const QuantitySummary& s, double half_width) {
  const auto is_enough = [&](int n) {
    return sequential_half_width(*s.scatter_sd, s.shared_sd, n) <= half_width;
  };
  int few = std::max(s.n, kMinSequentialShots - 1), many = kMaxShots;
  while (many - few > 1) {
    const int middle = few + (many - few) / 2;
    (is_enough(middle) ? many : few) = middle;
  }
  return many - s.n;
}

}  // namespace

Known known_so_far(const SeriesSummary& summary, const Wanted& wanted) {
  const QuantitySummary& s = summary.quantities[static_cast<std::size_t>(wanted.quantity)];
  Known known;
  known.wanted = wanted;
  known.n = s.n;
  if (s.n == 0) {
    if (summary.counted >= kMinSequentialShots) known.state = Known::State::no_value;
    return known;
  }
  assert(s.shared_known);
  known.wanted_half_width = wanted.size(s.mean);
  known.shared_half_width = mean_half_width(0.0, s.shared_sd, 2);
  if (!(known.shared_half_width < known.wanted_half_width)) {
    known.state = Known::State::never;
    return known;
  }
  if (s.n < 2) return known;
  known.half_width = sequential_half_width(*s.scatter_sd, s.shared_sd, s.n);
  if (s.n >= kMinSequentialShots && *known.half_width <= known.wanted_half_width) {
    known.state = Known::State::known;
    known.more = 0;
  } else {
    known.more = further_shots(s, known.wanted_half_width);
  }
  return known;
}

}  // namespace strobe::host
