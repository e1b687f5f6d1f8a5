#include "tests/benchmarks/timing/sample.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::benchmarks::timing {

Sample sample_of(MonoTime due, MonoTime done, int cpu) {
  return {due, done, static_cast<double>((done - due).count()) * 1e-3, cpu};
}

Percentiles percentiles(std::vector<double> lateness_us) {
  if (lateness_us.empty()) return {};
  std::sort(lateness_us.begin(), lateness_us.end());
  const auto rank = [&](double p) {
    const double position = std::ceil(p * static_cast<double>(lateness_us.size()));
    return lateness_us[static_cast<std::size_t>(std::max(1.0, position)) - 1];
  };
  return {lateness_us.size(), rank(0.5), rank(0.99), rank(0.999), lateness_us.back()};
}

std::vector<double> latenesses(const std::vector<Sample>& samples) {
  std::vector<double> values;
  for (const Sample& sample : samples) values.push_back(sample.lateness_us);
  return values;
}

std::vector<double> outside(const std::vector<Sample>& samples, const std::vector<Freeze>& freezes) {
  std::vector<double> values;
  for (const Sample& sample : samples)
    if (!within_freeze(freezes, sample.from, sample.to, sample.cpu)) values.push_back(sample.lateness_us);
  return values;
}

void append(std::vector<Sample>& to, const std::vector<Sample>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

}  // namespace strobe::benchmarks::timing
