#include "common/reduction/mixture.hpp"

#include <cmath>

namespace strobe::reduction {
namespace {

constexpr double kContradicted = 0.05;

struct Moments {
  double weight = 0.0, mean = 0.0, within = 0.0, systematic = 0.0, between = 0.0;
};

Moments moments_of(std::span<const MixtureComponent> hypotheses, Quantity q) {
  Moments m;
  for (const MixtureComponent& h : hypotheses) {
    if (!h.value[q]) continue;
    m.weight += h.weight;
    const double share = h.weight / m.weight;
    const double off = *h.value[q] - m.mean;
    m.mean += share * off;
    m.between += share * ((1.0 - share) * off * off + h.between[static_cast<std::size_t>(q)] - m.between);
    m.within += share * (std::pow(h.sd[q].value_or(0.0), 2) - m.within);
    m.systematic += share * (std::pow(h.sd_systematic[q].value_or(0.0), 2) - m.systematic);
  }
  return m;
}

void mix(const Moments& m, Quantity q, Readout& readout) {
  readout.value[q] = m.mean;
  readout.assignments->sd[q] = std::sqrt(m.between);
  if (readout.sd[q]) readout.sd[q] = std::sqrt(m.within + m.between);
  if (readout.sd_systematic[q]) readout.sd_systematic[q] = std::sqrt(m.systematic);
  if (readout.degrees_of_freedom[q] && m.within > 0.0)
    *readout.degrees_of_freedom[q] *= std::pow(1.0 + m.between / m.within, 2);
}

}  // namespace

void mix(std::span<const MixtureComponent> hypotheses, Readout& likeliest) {
  likeliest.assignments.emplace().hypotheses = 0;
  likeliest.covariance.reset();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (likeliest.value[q]) mix(moments_of(hypotheses, q), q, likeliest);
  }
  double all = 0.0, other = 0.0;
  for (const MixtureComponent& h : hypotheses) {
    likeliest.assignments->hypotheses += h.hypotheses;
    all += h.weight;
    if (h.regime != likeliest.regime) other += h.weight;
  }
  if (likeliest.regime && other > kContradicted * all) likeliest.regime = Regime::unclear;
  if (mixture_ambiguous(likeliest)) likeliest.flags.set(Flag::flash_match_ambiguous);
}

bool mixture_ambiguous(const Readout& mixture) {
  if (!mixture.assignments) return false;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto& between = mixture.assignments->sd[q];
    const auto& all = mixture.sd[q];
    if (between && all && 2.0 * *between * *between > *all * *all) return true;
  }
  return false;
}

}  // namespace strobe::reduction
