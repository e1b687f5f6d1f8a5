#include "common/reduction/equator_consensus.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/reduction/spin_line.hpp"
#include "common/statistics/distributions.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

/// Samples tried; some thousand lines through forty readings take a millisecond.
constexpr int kMaxSamples = 4000;
constexpr double kAsGood = 9.0;
/// Times its noise by which the rest may miss the consensus as readings do: with few of them Student's t
/// allows anything.
constexpr double kMaxNoiseRatio = 3.0;

class Consensus {
 public:
  Consensus(const std::vector<EquatorReading>& readings, double usual_sd_rad) : readings_(readings) {
    for (const EquatorReading& r : readings) {
      const double sd = r.estimated_noise ? usual_sd_rad : r.sd_rad;
      variance_.push_back(sd * sd);
    }
  }

  /// A line through two readings, then through all that lie near, twice.
  void sample(std::size_t i, std::size_t k, double omega) {
    const EquatorReading& a = readings_[i];
    const EquatorReading& b = readings_[k];
    SpinLine line;
    line.add(a.time_s, a.angle_rad, 1.0 / noise(i, omega));
    line.add(b.time_s, a.angle_rad + omega * (b.time_s - a.time_s), 1.0 / noise(k, omega));
    for (int round = 0; round < 2; ++round) line = through_near(line);
    const double cost = cost_of(line);
    const bool same =
        best_ && std::abs(line.slope() - best_->slope()) < 6.0 * std::sqrt(line.slope_variance());
    if (best_ && !same) other_cost_ = std::min(other_cost_, std::max(cost, best_cost_));
    if (cost < best_cost_) best_cost_ = cost, best_ = line;
  }

  bool unique() const { return best_ && other_cost_ >= best_cost_ + kAsGood; }
  const SpinLine& best() const { return *best_; }

  SpinLine through_near(const SpinLine& nearby) const {
    SpinLine line;
    for (std::size_t i = 0; i < readings_.size(); ++i) {
      const EquatorReading& r = readings_[i];
      const double off = miss(r, nearby);
      const double own = noise(i, nearby.slope());
      if (off * off > kCostLimit * (own + nearby.variance_at(r.time_s))) continue;
      line.add(r.time_s, nearby.at(r.time_s) + off, 1.0 / own);
    }
    return line.moment() > 0.0 ? line : nearby;
  }

  double noise(std::size_t i, double omega) const {
    const double by_time = omega * readings_[i].time_sd_s;
    return variance_[i] + by_time * by_time;
  }

 private:
  double cost_of(const SpinLine& line) const {
    double cost = 0.0;
    for (std::size_t i = 0; i < readings_.size(); ++i) {
      const double off = miss(readings_[i], line);
      cost += std::min(off * off / noise(i, line.slope()), kCostLimit);
    }
    return cost;
  }

  const std::vector<EquatorReading>& readings_;
  std::vector<double> variance_;
  std::optional<SpinLine> best_;
  double best_cost_ = std::numeric_limits<double>::infinity();
  double other_cost_ = std::numeric_limits<double>::infinity();
};

/// All pairs, the nearest first, with every spin of the window that each allows.
void sample_all(const std::vector<EquatorReading>& readings, double window_radps, Consensus& consensus) {
  int left = kMaxSamples;
  for (std::size_t step = 1; step < readings.size(); ++step) {
    for (std::size_t i = 0; i + step < readings.size(); ++i) {
      const EquatorReading& a = readings[i];
      const EquatorReading& b = readings[i + step];
      const double interval = b.time_s - a.time_s;
      const double base = wrap_half_turn(b.angle_rad - a.angle_rad) / interval;
      const double branch = kPi / interval;
      const double first = std::ceil((-window_radps - base) / branch);
      for (double n = first; base + n * branch <= window_radps; n += 1.0) {
        if (left-- == 0) return;
        consensus.sample(i, i + step, base + n * branch);
      }
    }
  }
}

double subsets(std::size_t of, std::size_t size) {
  double count = 1.0;
  for (std::size_t i = 0; i < size; ++i) count *= static_cast<double>(of - i) / static_cast<double>(i + 1);
  return count;
}

}  // namespace

bool equators_agree(const std::vector<EquatorReading>& readings, const SpinFit& fit, double usual_sd_rad) {
  if (improbable(fit.chi_squared, readings.size())) return false;
  return std::ranges::none_of(
      readings, [&](const EquatorReading& r) { return r.estimated_noise && r.sd_rad > 1.5 * usual_sd_rad; });
}

std::vector<std::size_t> outside_consensus(const std::vector<EquatorReading>& readings, double window_radps,
                                           double usual_sd_rad, double false_alarms) {
  Consensus consensus(readings, usual_sd_rad);
  sample_all(readings, window_radps, consensus);
  if (!consensus.unique()) return {};
  const SpinLine line = consensus.through_near(consensus.best());
  std::vector<std::size_t> outside;
  double chi_squared = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const double off = miss(readings[i], line);
    const double own = consensus.noise(i, line.slope());
    if (off * off > kCostLimit * (own + line.variance_at(readings[i].time_s))) {
      outside.push_back(i);
    } else {
      chi_squared += off * off / own;
    }
  }
  const std::size_t inside = readings.size() - outside.size();
  if (outside.empty() || inside < 3 || 2 * inside <= readings.size()) return {};
  const double freedom = static_cast<double>(inside) - 2.0;
  // Where the noise is larger than it should be the consensus scatters more, and so may the rest.
  const double scale = std::max(1.0, chi_squared / freedom);
  const double chances = subsets(readings.size(), outside.size());
  for (const std::size_t i : outside) {
    const double off = miss(readings[i], line);
    const double variance = scale * (consensus.noise(i, line.slope()) + line.variance_at(readings[i].time_s));
    const double t = std::abs(off) / std::sqrt(variance);
    const double chance =
        std::min(statistics::student_t_tail(t, freedom), std::erfc(t / kMaxNoiseRatio / std::sqrt(2.0)));
    if (!(chance * chances < false_alarms)) return {};
  }
  return outside;
}

}  // namespace strobe::reduction
