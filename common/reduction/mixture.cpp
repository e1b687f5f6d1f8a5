#include "common/reduction/mixture.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "common/reduction/reduce.hpp"
#include "common/statistics/distributions.hpp"

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

// Times that differ by this share of the shortest interval change a velocity by as much to first order, and
// to second order by its square, 2.5e-5 of the velocity: a tenth of what the best photographs leave
// uncertain.
constexpr double kLinearShare = 0.005;

double shortest_interval_s(const Frame& frame) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < frame.images.size(); ++i)
    shortest = std::min(shortest, frame.images[i].time_s - frame.images[i - 1].time_s);
  return shortest;
}

/// Hypotheses whose times are alike, the likeliest first.
struct Group {
  std::vector<const AssignedTimes*> members;
};

/// A height goes with the square of the speed, but for what drag changes in its small part.
void follow(double own_mps, const Readout& mixed, Quantity q, DerivedNumber& height) {
  const double own = std::abs(own_mps), now = std::abs(*mixed.value[q]);
  if (!(own > 0.0 && now > 0.0)) return;
  height.value *= (now / own) * (now / own);
  height.sd = std::hypot(height.sd, 2.0 * height.value / now * mixed.assignments->sd[q].value_or(0.0));
}

/// What a readout's numbers are at other times than its own, to first order.
std::array<double, kQuantityCount> changes(const Readout& readout, const AssignedTimes& own,
                                           const AssignedTimes& other) {
  std::array<double, kQuantityCount> sum{};
  for (std::size_t i = 0; i < readout.by_time.size(); ++i) {
    const double off_s = other.time_s[i] - own.time_s[i];
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += readout.by_time[i][k] * off_s;
  }
  return sum;
}

/// Of a group whose first member has this readout.
MixtureComponent component_of(const Readout& readout, const Group& group) {
  assert(!group.members.empty());
  MixtureComponent all{readout.value, readout.sd, readout.sd_systematic, readout.regime, 0.0};
  all.hypotheses = static_cast<int>(group.members.size());
  std::array<double, kQuantityCount> mean{};
  for (const AssignedTimes* one : group.members) {
    all.weight += one->weight;
    const double share = one->weight / all.weight;
    const auto change = changes(readout, *group.members.front(), *one);
    for (std::size_t k = 0; k < mean.size(); ++k) {
      const double off = change[k] - mean[k];
      mean[k] += share * off;
      all.between[k] += share * ((1.0 - share) * off * off - all.between[k]);
    }
  }
  for (std::size_t k = 0; k < mean.size(); ++k) {
    auto& value = all.value[static_cast<Quantity>(k)];
    if (value) *value += mean[k];
  }
  return all;
}

class Mixing {
 public:
  Mixing(const Frame& frame, std::span<const AssignedTimes> hypotheses)
      : frame_(frame), linear_s_(kLinearShare * shortest_interval_s(frame)) {
    for (const AssignedTimes& one : hypotheses) add(one);
  }

  /// `first`: the frame's own, with Readout::by_time.
  std::vector<MixtureComponent> run(const Readout& first) const {
    assert(!groups_.empty() && first.by_time.size() <= frame_.images.size());
    std::vector<MixtureComponent> mixed{component_of(first, groups_.front())};
    mixed.reserve(groups_.size());
    for (std::size_t g = 1; g < groups_.size(); ++g) {
      const auto readout = reduced(groups_[g], first.flight_effects);
      if (readout) mixed.push_back(component_of(*readout, groups_[g]));
    }
    return mixed;
  }

 private:
  void add(const AssignedTimes& one) {
    const auto group =
        std::ranges::find_if(groups_, [&](const Group& g) { return alike(*g.members.front(), one); });
    if (group != groups_.end()) {
      group->members.push_back(&one);
    } else if (std::ssize(groups_) < kMaxReduced) {
      groups_.push_back({{&one}});
    }
  }

  bool alike(const AssignedTimes& a, const AssignedTimes& b) const {
    for (std::size_t i = 0; i < frame_.images.size(); ++i)
      if (!(std::abs(a.time_s[i] - b.time_s[i]) <= linear_s_)) return false;
    return true;
  }

  /// With the same effects of the flight, so that numbers do not jump.
  std::optional<Readout> reduced(const Group& group, const flight::Effects& effects) const {
    Frame frame = frame_;
    for (std::size_t i = 0; i < frame.images.size(); ++i)
      frame.images[i].time_s = group.members.front()->time_s[i];
    auto readout = reduce(frame, Estimator::best, {.effects = effects, .by_time = group.members.size() > 1});
    if (!readout) return std::nullopt;
    return std::move(*readout);
  }

  const Frame& frame_;
  double linear_s_;
  std::vector<Group> groups_;
};

double part_sd(const Budget& budget, Quantity q, bool systematic) {
  double sd = 0.0;
  for (const BudgetSource& s : budget.sources)
    if (is_systematic(s.source) == systematic) sd = std::hypot(sd, s.of(q));
  return sd;
}

/// Without Student's factor, as the lines are.
double estimated_sd(const Readout& readout, Quantity q) {
  const double sd = readout.sd[q].value_or(0.0);
  const auto& freedom = readout.degrees_of_freedom[q];
  return freedom && *freedom > 0.0 ? sd / statistics::student_t_sigma(*freedom) : sd;
}

void scale_part(Budget& budget, Quantity q, bool systematic, double to) {
  const double now = part_sd(budget, q, systematic);
  if (!(now > 0.0)) return;
  for (BudgetSource& s : budget.sources)
    if (is_systematic(s.source) == systematic) s.effect[static_cast<std::size_t>(q)] *= to / now;
  if (systematic) return;  // none of it is the shot's own
  for (std::size_t k = 0; k < kQuantityCount; ++k) {
    budget.own_covariance[static_cast<std::size_t>(q)][k] *= to / now;
    budget.own_covariance[k][static_cast<std::size_t>(q)] *= to / now;
  }
}

void add_assignments(const Readout& readout, Budget& budget) {
  BudgetSource assignment{.source = Source::assignment};
  bool any = false;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const double between = readout.assignments->sd[q].value_or(0.0);
    if (!(between > 0.0)) continue;
    any = true;
    const double sd = estimated_sd(readout, q);
    scale_part(budget, q, false, std::sqrt(std::max(0.0, (sd - between) * (sd + between))));
    scale_part(budget, q, true, readout.sd_systematic[q].value_or(0.0));
    assignment.effect[i] = between;
    budget.own_covariance[i][i] += between * between;
  }
  if (!any) return;
  const auto place = std::ranges::find_if(
      budget.sources, [](const BudgetSource& s) { return s.source > Source::assignment; });
  budget.sources.insert(place, assignment);
}

}  // namespace

void mix(std::span<const MixtureComponent> hypotheses, Readout& likeliest) {
  likeliest.assignments.emplace().hypotheses = 0;
  likeliest.covariance.reset();
  const Quantities own = likeliest.value;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (likeliest.value[q]) mix(moments_of(hypotheses, q), q, likeliest);
  }
  if (likeliest.drop) {
    follow(*own[Quantity::vy_td_mps], likeliest, Quantity::vy_td_mps, likeliest.drop->fall_height_m);
    follow(*own[Quantity::vy_lo_mps], likeliest, Quantity::vy_lo_mps, likeliest.drop->rebound_height_m);
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

Result<Readout> reduce_hypotheses(const Frame& frame, std::span<const AssignedTimes> hypotheses) {
  auto readout = reduce(frame, Estimator::best, {.by_time = hypotheses.size() > 1, .likely_cause = true});
  if (!readout || hypotheses.empty()) return readout;
  mix(Mixing(frame, hypotheses).run(*readout), *readout);
  readout->by_time.clear();
  return readout;
}

Budget mixture_budget(const Frame& frame, const Readout& mixture) {
  if (frame.images.empty()) return {};
  auto budget = uncertainty_budget(frame);
  if (!budget) return {};
  if (mixture.assignments) add_assignments(mixture, *budget);
  return std::move(*budget);
}

}  // namespace strobe::reduction
