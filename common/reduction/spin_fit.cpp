#include "common/reduction/spin_fit.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/reduction/spin_line.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

/// Half turns tried between two readings far apart; more are beyond any flash train.
constexpr int kMaxBranches = 1000;
/// Share of the window's width next to its limit where a turn more is as likely as the spin itself.
constexpr double kNearLimit = 0.05;

/// The line through readings `pair` and `pair + 1` with that spin, extended to the others, nearest first.
SpinLine follow(const std::vector<EquatorReading>& readings, std::size_t pair, double omega) {
  const EquatorReading& first = readings[pair];
  const EquatorReading& second = readings[pair + 1];
  SpinLine line;
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

struct Proposal {
  SpinLine line;
  double omega = 0.0;
  double cost = 0.0;
};

double robust_cost(const std::vector<EquatorReading>& readings, const SpinLine& line) {
  double cost = 0.0;
  for (const EquatorReading& r : readings) {
    const double miss = wrap_half_turn(r.angle_rad - line.at(r.time_s));
    cost += std::min(miss * miss * weight(r, line.slope()), kCostLimit);
  }
  return cost;
}

struct Interval {
  double from_s = 0.0;
  double length_s = std::numeric_limits<double>::infinity();
};

/// The shortest between two of both, each in order of time.
Interval shortest_interval(const std::vector<EquatorReading>& readings,
                           const std::vector<EquatorReading>& left_out) {
  Interval shortest;
  std::optional<double> before;
  for (std::size_t i = 0, j = 0; i < readings.size() || j < left_out.size();) {
    const bool first =
        j >= left_out.size() || (i < readings.size() && readings[i].time_s < left_out[j].time_s);
    const double time = first ? readings[i++].time_s : left_out[j++].time_s;
    if (before && time > *before && time - *before < shortest.length_s) shortest = {*before, time - *before};
    before = time;
  }
  return shortest;
}

bool within(double omega, double limit) { return std::abs(omega) <= limit * (1.0 + 1e-12); }

/// All spins up to the limit that readings `pair` and `pair + 1` allow.
void propose_from(std::size_t pair, const std::vector<EquatorReading>& readings,
                  const std::vector<EquatorReading>& left_out, double limit,
                  std::vector<Proposal>& proposals) {
  const double interval = readings[pair + 1].time_s - readings[pair].time_s;
  const double base = wrap_half_turn(readings[pair + 1].angle_rad - readings[pair].angle_rad) / interval;
  const double branch = kPi / interval;
  if (!std::isfinite(base)) return;
  const double branches = std::ceil((limit + std::abs(base)) / branch);
  const int most = branches < kMaxBranches ? static_cast<int>(branches) : kMaxBranches;
  for (int k = -most; k <= most; ++k) {
    const double omega = base + k * branch;
    if (!within(omega, limit)) continue;
    const SpinLine line = follow(readings, pair, omega);
    if (!within(line.slope(), limit)) continue;
    proposals.push_back({line, line.slope(), robust_cost(readings, line) + robust_cost(left_out, line)});
  }
}

std::vector<Proposal> propose(const std::vector<EquatorReading>& readings,
                              const std::vector<EquatorReading>& left_out, double limit) {
  std::vector<Proposal> proposals;
  proposals.reserve(readings.size());
  for (std::size_t i = 0; i + 1 < readings.size(); ++i) propose_from(i, readings, left_out, limit, proposals);
  return proposals;
}

std::size_t shortest_pair(const std::vector<EquatorReading>& readings) {
  std::size_t shortest = 0;
  for (std::size_t i = 1; i + 1 < readings.size(); ++i) {
    if (readings[i + 1].time_s - readings[i].time_s <
        readings[shortest + 1].time_s - readings[shortest].time_s)
      shortest = i;
  }
  return shortest;
}

void finish(const std::vector<EquatorReading>& readings, const SpinLine& line, SpinFit& fit) {
  fit.omega_radps = line.slope();
  fit.variance = 1.0 / line.moment();
  fit.residual_rad.reserve(readings.size());
  fit.leverage.reserve(readings.size());
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

/// The likeliest spin of the window; the slower of two that are as likely.
Proposal best_of(const std::vector<Proposal>& proposals, const std::vector<EquatorReading>& readings,
                 double window) {
  constexpr double kAsLikely = 1.0;  // a likelihood ratio of 1.6
  double least = std::numeric_limits<double>::infinity();
  for (const Proposal& p : proposals) {
    if (within(p.omega, window)) least = std::min(least, p.cost);
  }
  const Proposal* best = nullptr;
  for (const Proposal& p : proposals) {
    if (!within(p.omega, window) || p.cost > least + kAsLikely) continue;
    if (!best || std::abs(p.omega) < std::abs(best->omega)) best = &p;
  }
  if (best) return *best;
  // Noise at the very edge of the window took every line out of it: keep the first pair's own spin.
  const double omega = wrap_half_turn(readings[1].angle_rad - readings[0].angle_rad) /
                       (readings[1].time_s - readings[0].time_s);
  const SpinLine line = follow(readings, 0, omega);
  return {line, line.slope(), robust_cost(readings, line)};
}

double span_s(const std::vector<EquatorReading>& readings) {
  return readings.back().time_s - readings.front().time_s;
}

/// The same line with another spin, about the reading that both go through, fitted once more.
SpinLine turned(const std::vector<EquatorReading>& readings, const SpinLine& line, double by_radps,
                double time_s) {
  SpinLine other;
  for (const EquatorReading& r : readings) {
    const double expected = line.at(r.time_s) + by_radps * (r.time_s - time_s);
    other.add(r.time_s, expected + wrap_half_turn(r.angle_rad - expected),
              weight(r, line.slope() + by_radps));
  }
  return other;
}

/// Whatever explains the readings as well must turn by whole half turns more in the shortest interval.
class Alternatives {
 public:
  Alternatives(const std::vector<EquatorReading>& readings, const std::vector<EquatorReading>& left_out,
               const Proposal& best, double decay_per_s, SpinFit& fit)
      : readings_(readings),
        left_out_(left_out),
        best_(best),
        apart_radps_(std::max(6.0 * std::sqrt(fit.variance), 0.5 * kPi / span_s(readings))),
        decay_per_s_(decay_per_s),
        fit_(fit) {}

  void within_window(const std::vector<Proposal>& proposals) {
    for (const Proposal& other : proposals) add(other.line);
  }

  /// Whether the same turn the other way explains them.
  bool other_way(const Interval& shortest) {
    const double branch = std::copysign(kPi / shortest.length_s, best_.omega);
    return explains_as_well(turned(readings_, best_.line, -branch, shortest.from_s));
  }

  void beyond(double window, const Interval& shortest, double fastest_radps) {
    const double branch = kPi / shortest.length_s;
    const double most = (fastest_radps + std::abs(best_.omega)) / branch;
    if (!(most >= 1.0)) return;
    const int count = most < kMaxBranches ? static_cast<int>(most) : kMaxBranches;
    for (int k = -count; k <= count; ++k) {
      const double omega = best_.omega + k * branch;
      if (k == 0 || within(omega, window) || !within(omega, fastest_radps)) continue;
      const SpinLine line = turned(readings_, best_.line, k * branch, shortest.from_s);
      add(line);
    }
  }

 private:
  /// The best line's own decay need not be the assumed one either.
  bool explains_as_well(const SpinLine& line) {
    const double of_left_out = robust_cost(left_out_, line);
    const double cost = robust_cost(readings_, line) + of_left_out;
    if (cost < kComparableSpins) return true;  // none costs less than nothing
    if (decay_per_s_ == 0.0) return cost < best_.cost + kComparableSpins;
    if (std::isnan(least_))
      least_ = cost_at_any_decay(readings_, best_.line, decay_per_s_) + robust_cost(left_out_, best_.line);
    if (cost < least_ + kComparableSpins) return true;
    return cost_at_any_decay(readings_, line, decay_per_s_) + of_left_out < least_ + kComparableSpins;
  }

  void add(const SpinLine& line) {
    const double omega = line.slope();
    const auto same = [&](double known) { return std::abs(known - omega) <= apart_radps_; };
    if (same(best_.omega) || !explains_as_well(line)) return;
    if (std::ranges::none_of(fit_.alternatives_radps, same)) fit_.alternatives_radps.push_back(omega);
  }

  const std::vector<EquatorReading>& readings_;
  const std::vector<EquatorReading>& left_out_;
  const Proposal& best_;
  /// Lines a quarter turn apart over all readings put each at the same half turn; another spin's are half a
  /// turn apart.
  double apart_radps_;
  double decay_per_s_;
  double least_ =
      std::numeric_limits<double>::quiet_NaN();  ///< of the best line at any decay; NaN: not asked yet
  SpinFit& fit_;
};

double mean_time_s(const std::vector<EquatorReading>& readings) {
  double mean = 0.0;
  for (const EquatorReading& r : readings) mean += r.time_s / static_cast<double>(readings.size());
  return mean;
}

/// About `time_s`.
SpinFit fit_steady_spin(const std::vector<EquatorReading>& readings,
                        const std::vector<EquatorReading>& left_out, const SpinSearch& search,
                        double time_s) {
  const Interval shortest = shortest_interval(readings, left_out);
  const double of_train = kPi / (2.0 * search.shortest_interval_s);
  const double window = std::max(kPi / (2.0 * shortest.length_s), std::min(of_train, search.fastest_radps));
  std::vector<Proposal> proposals = propose(readings, left_out, window);
  Proposal best = best_of(proposals, readings, window);
  const auto at_any_decay = [&](Proposal& p) {
    p.cost = cost_at_any_decay(readings, p.line, search.decay_per_s) + robust_cost(left_out, p.line);
  };
  if (improbable(best.cost, readings.size()) && search.decay_per_s != 0.0) {
    // Another decay than assumed is no evidence for another spin.
    std::ranges::for_each(proposals, at_any_decay);
    best = best_of(proposals, readings, window);
  }
  // Unequal intervals tell a spin beyond the window from those within, where it does explain the readings.
  // Of spins none of which does, the readings' noise is larger than stated, and the window's stays.
  for (const double limit : {search.fastest_radps, search.possible_radps}) {
    if (!improbable(best.cost, readings.size()) || !(limit > window)) continue;
    std::vector<Proposal> more = propose(readings, left_out, limit);
    // The faster a ball spins, the more of any bend a decay would explain.
    if (search.decay_per_s != 0.0 && limit == search.fastest_radps) std::ranges::for_each(more, at_any_decay);
    const Proposal faster = best_of(more, readings, limit);
    const double better = limit > search.fastest_radps ? kFarBetter : kComparableSpins;
    const bool explains = !improbable(faster.cost, readings.size()) && faster.cost + better < best.cost;
    if (explains) best = faster;
    if (limit == search.fastest_radps) proposals = std::move(more);
  }
  SpinFit fit;
  fit.window_radps = window;
  fit.interval_s = shortest.length_s;
  const SpinLine line = through_all(readings, best.line);
  finish(readings, line, fit);
  fit.time_s = time_s;
  fit.angle_rad = line.at(time_s);
  allow_for_decay(readings, line, search.decay_sd_per_s, fit);
  Alternatives alternatives(readings, left_out, best, search.decay_per_s, fit);
  fit.near_limit =
      std::abs(fit.omega_radps) + std::max(3.0 * std::sqrt(fit.variance), kNearLimit * window) > window &&
      alternatives.other_way(shortest);
  alternatives.within_window(proposals);
  alternatives.beyond(window, shortest, search.fastest_radps);
  return fit;
}

}  // namespace

std::vector<EquatorReading> stretched(std::vector<EquatorReading> readings, double from_s,
                                      double decay_per_s) {
  if (decay_per_s == 0.0) return readings;
  for (EquatorReading& r : readings)
    r.time_s = from_s - std::expm1(-decay_per_s * (r.time_s - from_s)) / decay_per_s;
  return readings;
}

std::optional<SpinFit> fit_spin(const std::vector<EquatorReading>& readings,
                                const std::vector<EquatorReading>& left_out, const SpinSearch& search) {
  assert(
      std::is_sorted(readings.begin(), readings.end(),
                     [](const EquatorReading& a, const EquatorReading& b) { return a.time_s < b.time_s; }));
  if (readings.size() < 2) return std::nullopt;
  const double time_s = mean_time_s(readings);
  const double decay = search.decay_per_s;
  if (decay == 0.0) return fit_steady_spin(readings, left_out, search, time_s);
  return fit_steady_spin(stretched(readings, time_s, decay), stretched(left_out, time_s, decay), search,
                         time_s);
}

std::vector<OtherSpin> faster_spins(const std::vector<EquatorReading>& as_read,
                                    const std::vector<EquatorReading>& as_left_out, const SpinSearch& search,
                                    const SpinFit& fit) {
  if (as_read.size() < 2 || !(search.possible_radps > search.fastest_radps)) return {};
  const auto readings = stretched(as_read, fit.time_s, search.decay_per_s);
  const auto left_out = stretched(as_left_out, fit.time_s, search.decay_per_s);
  const auto cost = [&](const SpinLine& line) {
    const double of_readings = search.decay_per_s == 0.0
                                   ? robust_cost(readings, line)
                                   : cost_at_any_decay(readings, line, search.decay_per_s);
    return of_readings + robust_cost(left_out, line);
  };
  SpinLine fitted;
  fitted.add(fit.time_s, fit.angle_rad, 1.0);
  fitted.add(fit.time_s + fit.interval_s, fit.angle_rad + fit.omega_radps * fit.interval_s, 1.0);
  const double limit = cost(fitted) + kComparableSpins;
  const std::size_t pair = shortest_pair(readings);
  const double apart = 0.5 * kPi / (readings[pair + 1].time_s - readings[pair].time_s);
  std::vector<Proposal> proposals;
  propose_from(pair, readings, left_out, search.possible_radps, proposals);
  // A line by other weights than the alternatives' may be as much slower.
  constexpr double kSlower = 0.98;
  std::vector<OtherSpin> others;
  for (const Proposal& p : proposals) {
    if (std::abs(p.omega) <= kSlower * search.fastest_radps) continue;
    if (std::abs(p.omega - fit.omega_radps) < apart) continue;
    // No decay makes up for more than two readings that are off.
    if (p.cost > limit + 2.0 * kCostLimit) continue;
    const double other = cost(p.line);
    if (!(other < limit)) continue;
    const bool probable = p.cost < kComparableSpins || !improbable(p.cost, readings.size());
    others.push_back({p.omega, other - limit + kComparableSpins, probable});
  }
  return others;
}

}  // namespace strobe::reduction
