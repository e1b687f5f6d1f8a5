#include "host/assembly/shot_mixture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "common/reduction/mixture.hpp"
#include "common/reduction/reduce.hpp"

namespace strobe::host {
namespace {

using reduction::Frame;
using reduction::MixtureComponent;
using reduction::Quantity;
using reduction::Readout;

// Times that differ by this share of the shortest interval change a velocity by as much to first order, and to second
// order by its square, 2.5e-5 of the velocity: a tenth of what the best photographs leave uncertain.
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

/// What a readout's numbers are at other times than its own, to first order.
std::array<double, reduction::kQuantityCount> changes(const Readout& readout, const AssignedTimes& own,
                                                      const AssignedTimes& other) {
  std::array<double, reduction::kQuantityCount> sum{};
  for (std::size_t i = 0; i < readout.by_time.size(); ++i) {
    const double off_s = other.time_s[i] - own.time_s[i];
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += readout.by_time[i][k] * off_s;
  }
  return sum;
}

/// Of a group whose first member has this readout.
MixtureComponent component_of(const Readout& readout, const Group& group) {
  MixtureComponent all{readout.value, readout.sd, readout.sd_systematic, readout.regime, 0.0};
  all.hypotheses = static_cast<int>(group.members.size());
  std::array<double, reduction::kQuantityCount> mean{};
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
    auto readout = reduction::reduce(frame, reduction::Estimator::best,
                                     {.effects = effects, .by_time = group.members.size() > 1});
    if (!readout) return std::nullopt;
    return std::move(*readout);
  }

  const Frame& frame_;
  double linear_s_;
  std::vector<Group> groups_;
};

}  // namespace

Result<Readout> reduce_hypotheses(const Frame& frame, std::span<const AssignedTimes> hypotheses) {
  auto readout = reduction::reduce(frame, reduction::Estimator::best, {.by_time = hypotheses.size() > 1});
  if (!readout || hypotheses.empty()) return readout;
  reduction::mix(Mixing(frame, hypotheses).run(*readout), *readout);
  readout->by_time.clear();
  return readout;
}

}  // namespace strobe::host
