#include "common/reduction/spin_fit.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/geometry/regression.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

/// A reading further out than this many sd costs no more: it is wrong, not unlikely.
constexpr double kCostLimit = 16.0;
/// Spins whose chi squared differs by less than 3 sd are indistinguishable.
constexpr double kComparable = 9.0;
/// Half turns tried between two readings far apart; more are beyond any flash train.
constexpr int kMaxBranches = 1000;
/// Share of the window's width next to its limit where a turn more is as likely as the spin itself.
constexpr double kNearLimit = 0.05;

/// angle = mean + omega (t - mean time)
using Line = geometry::LinearRegression<double>;

double weight(const EquatorReading& r, double omega) {
  const double by_time = omega * r.time_sd_s;
  return 1.0 / (r.sd_rad * r.sd_rad + by_time * by_time);
}

/// The line through readings `pair` and `pair + 1` with that spin, extended to the others, nearest first.
Line follow(const std::vector<EquatorReading>& readings, std::size_t pair, double omega) {
  const EquatorReading& first = readings[pair];
  const EquatorReading& second = readings[pair + 1];
  Line line;
  line.add(first.time_s, first.angle_rad, weight(first, omega));
  line.add(second.time_s, first.angle_rad + omega * (second.time_s - first.time_s), weight(second, omega));
  std::size_t before = pair;
  std::size_t after = pair + 2;
  while (before > 0 || after < readings.size()) {
    const double mean = line.mean_x();
    const bool backward = after >= readings.size() ||
                          (before > 0 && mean - readings[before - 1].time_s < readings[after].time_s - mean);
    const EquatorReading& next = readings[backward ? --before : after++];
    const double expected = line.at(next.time_s);
    const double miss = wrap_half_turn(next.angle_rad - expected);
    const double w = weight(next, omega);
    // A wrong reading must not lead the line astray from those that follow.
    if (miss * miss > kCostLimit * (1.0 / w + line.variance_at(next.time_s))) continue;
    line.add(next.time_s, expected + miss, w);
  }
  return line;
}

/// Least squares through all readings, each at the half turn nearest to the given line.
Line through_all(const std::vector<EquatorReading>& readings, const Line& nearby) {
  Line line;
  for (const EquatorReading& r : readings) {
    const double expected = nearby.at(r.time_s);
    line.add(r.time_s, expected + wrap_half_turn(r.angle_rad - expected), weight(r, nearby.slope()));
  }
  return line;
}

struct Proposal {
  Line line;
  double omega = 0.0;
  double cost = 0.0;
};

double robust_cost(const std::vector<EquatorReading>& readings, const Line& line) {
  double cost = 0.0;
  for (const EquatorReading& r : readings) {
    const double miss = wrap_half_turn(r.angle_rad - line.at(r.time_s));
    cost += std::min(miss * miss * weight(r, line.slope()), kCostLimit);
  }
  return cost;
}

/// Shortest interval between two of both, each in order of time.
double shortest_interval(const std::vector<EquatorReading>& readings,
                         const std::vector<EquatorReading>& left_out) {
  double shortest = std::numeric_limits<double>::infinity();
  std::optional<double> before;
  for (std::size_t i = 0, j = 0; i < readings.size() || j < left_out.size();) {
    const bool first =
        j >= left_out.size() || (i < readings.size() && readings[i].time_s < left_out[j].time_s);
    const double time = first ? readings[i++].time_s : left_out[j++].time_s;
    if (before && time > *before) shortest = std::min(shortest, time - *before);
    before = time;
  }
  return shortest;
}

std::vector<Proposal> propose(const std::vector<EquatorReading>& readings,
                              const std::vector<EquatorReading>& left_out, double limit) {
  std::vector<Proposal> proposals;
  for (std::size_t i = 0; i + 1 < readings.size(); ++i) {
    const double interval = readings[i + 1].time_s - readings[i].time_s;
    const double base = wrap_half_turn(readings[i + 1].angle_rad - readings[i].angle_rad) / interval;
    const double branch = kPi / interval;
    if (!std::isfinite(base)) continue;
    const double branches = std::ceil((limit + std::abs(base)) / branch);
    const int most = branches < kMaxBranches ? static_cast<int>(branches) : kMaxBranches;
    for (int k = -most; k <= most; ++k) {
      const double omega = base + k * branch;
      if (std::abs(omega) > limit * (1.0 + 1e-12)) continue;
      const Line line = follow(readings, i, omega);
      if (std::abs(line.slope()) > limit * (1.0 + 1e-12)) continue;
      proposals.push_back({line, line.slope(), robust_cost(readings, line) + robust_cost(left_out, line)});
    }
  }
  return proposals;
}

void finish(const std::vector<EquatorReading>& readings, const Line& line, SpinFit& fit) {
  fit.omega_radps = line.slope();
  fit.variance = 1.0 / line.moment();
  fit.mean_time_s = line.mean_x();
  fit.angle_rad = line.mean();
  for (const EquatorReading& r : readings) {
    const double dt = r.time_s - line.mean_x();
    const double w = weight(r, fit.omega_radps);
    const double miss = wrap_half_turn(r.angle_rad - line.at(r.time_s));
    fit.residual_rad.push_back(miss);
    fit.leverage.push_back(w * (1.0 / line.weight() + dt * dt / line.moment()));
    fit.chi_squared += miss * miss * w;
    const double share = r.sd_rad * r.sd_rad * w;  // less the part of a stated error in time
    if (r.estimated_noise) fit.estimated_variance += share * w * dt * dt / (line.moment() * line.moment());
  }
}

}  // namespace

std::optional<SpinFit> fit_spin(const std::vector<EquatorReading>& readings,
                                const std::vector<EquatorReading>& left_out) {
  assert(
      std::is_sorted(readings.begin(), readings.end(),
                     [](const EquatorReading& a, const EquatorReading& b) { return a.time_s < b.time_s; }));
  if (readings.size() < 2) return std::nullopt;
  const double limit = kPi / (2.0 * shortest_interval(readings, left_out));
  std::vector<Proposal> proposals = propose(readings, left_out, limit);
  if (proposals.empty()) {
    // Noise at the very edge of the window took every line out of it: keep the first pair's own spin.
    const double omega = wrap_half_turn(readings[1].angle_rad - readings[0].angle_rad) /
                         (readings[1].time_s - readings[0].time_s);
    const Line line = follow(readings, 0, omega);
    proposals.push_back({line, line.slope(), robust_cost(readings, line)});
  }
  const Proposal best =
      *std::min_element(proposals.begin(), proposals.end(),
                        [](const Proposal& a, const Proposal& b) { return a.cost < b.cost; });
  SpinFit fit;
  finish(readings, through_all(readings, best.line), fit);
  const double sd = std::sqrt(fit.variance);
  fit.aliased = std::abs(fit.omega_radps) + std::max(3.0 * sd, kNearLimit * limit) > limit;
  for (const Proposal& other : proposals) {
    const bool distinct = std::abs(other.omega - best.omega) > 6.0 * sd;
    fit.aliased = fit.aliased || (distinct && other.cost < best.cost + kComparable);
  }
  return fit;
}

}  // namespace strobe::reduction
