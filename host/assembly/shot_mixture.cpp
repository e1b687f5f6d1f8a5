#include "host/assembly/shot_mixture.hpp"

#include <algorithm>
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
// Of a number's variance: its sd is a hundredth too small without it.
constexpr double kNegligibleVariance = 0.02;
// Of the derivatives. Far above rounding, 1e-16 of a second over 1e-12 of a number, and far within linearity.
constexpr double kStep_s = 1e-7;

MixtureComponent component_of(const Readout& readout, double weight) {
  return {readout.value, readout.sd, readout.sd_systematic, readout.regime, weight};
}

double shortest_interval_s(const Frame& frame) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < frame.images.size(); ++i)
    shortest = std::min(shortest, frame.images[i].time_s - frame.images[i - 1].time_s);
  return shortest;
}

class Mixing {
 public:
  Mixing(const Frame& frame, std::span<const AssignedTimes> hypotheses, const Readout& first)
      : frame_(frame),
        all_(hypotheses),
        first_(first),
        linear_s_(kLinearShare * shortest_interval_s(frame)) {}

  std::vector<MixtureComponent> run() {
    std::vector<MixtureComponent> mixed{component_of(first_, all_.front().weight)};
    const auto alike = std::ranges::count_if(all_, [&](const AssignedTimes& one) { return is_alike(one); });
    if (alike > 1 && largest_share_of_variance() < kNegligibleVariance) {
      slopes_.assign(frame_.images.size(), {});
    } else if (alike > static_cast<std::ptrdiff_t>(frame_.images.size())) {
      differentiate();
    }
    int reduced = 0;
    for (const AssignedTimes& one : all_.subspan(1)) {
      if (!slopes_.empty() && is_alike(one)) {
        mixed.push_back(linear(one));
      } else if (reduced < kMaxReduced) {
        ++reduced;
        if (const auto readout = reduced_with(one.time_s))
          mixed.push_back(component_of(*readout, one.weight));
      }
    }
    return mixed;
  }

 private:
  /// Bound of the variance between alike hypotheses over that within, for any number. A number is a sum of the centres
  /// with weights; an error in time moves a centre by the ball's speed times it, and by Cauchy and Schwarz the number
  /// by no more of its sd than the root of the sum of these displacements' squares over the centres' variances.
  double largest_share_of_variance() const {
    double sum = 0.0, weight = 0.0;
    for (const AssignedTimes& one : all_) {
      if (!is_alike(one)) continue;
      weight += one.weight;
      for (std::size_t i = 0; i < frame_.images.size(); ++i)
        sum += one.weight * std::pow(displacement_in_sds(i, one.time_s[i] - frame_.images[i].time_s), 2);
    }
    return sum / weight;
  }

  /// Infinite where the frame does not state the centres' noise.
  double displacement_in_sds(std::size_t i, double off_s) const {
    const auto& image = frame_.images[i];
    const std::size_t k = i > 0 ? i - 1 : 1;
    const auto& neighbour = frame_.images[std::min(k, frame_.images.size() - 1)];
    const double way =
        std::hypot(image.centre_px.x - neighbour.centre_px.x, image.centre_px.y - neighbour.centre_px.y);
    const double variance = image.centre_cov_px2
                                ? std::min((*image.centre_cov_px2)[0], (*image.centre_cov_px2)[3])
                                : std::pow(frame_.centre_sd_px.value_or(0.0), 2);
    const double off_px = off_s == 0.0 ? 0.0 : way / (image.time_s - neighbour.time_s) * off_s;
    return variance > 0.0 ? off_px / std::sqrt(variance) : std::numeric_limits<double>::infinity();
  }

  bool is_alike(const AssignedTimes& one) const {
    for (std::size_t i = 0; i < frame_.images.size(); ++i)
      if (!(std::abs(one.time_s[i] - frame_.images[i].time_s) <= linear_s_)) return false;
    return true;
  }

  /// With the same effects of the flight, so that numbers do not jump.
  std::optional<Readout> reduced_with(const std::vector<double>& times_s) const {
    Frame frame = frame_;
    for (std::size_t i = 0; i < frame.images.size(); ++i) frame.images[i].time_s = times_s[i];
    auto readout = reduction::reduce(frame, reduction::Estimator::best, {.effects = first_.flight_effects});
    if (!readout) return std::nullopt;
    return std::move(*readout);
  }

  /// Leaves slopes_ empty where a number appears or disappears, or an image is left out, with so small a step.
  void differentiate() {
    std::vector<double> times_s;
    for (const auto& image : frame_.images) times_s.push_back(image.time_s);
    const auto here = reduced_with(times_s);
    for (std::size_t i = 0; here && i < times_s.size(); ++i) {
      if (frame_.images[i].leg == Leg::contact) {  // no number hangs on it
        slopes_.emplace_back();
        continue;
      }
      std::vector<double> moved = times_s;
      moved[i] += kStep_s;
      const auto there = reduced_with(moved);
      if (!there || there->flags != here->flags) {
        slopes_.clear();
        return;
      }
      auto& slopes = slopes_.emplace_back();
      for (std::size_t k = 0; k < reduction::kQuantityCount; ++k) {
        const auto q = static_cast<Quantity>(k);
        if (here->value[q] && there->value[q]) slopes[k] = (*there->value[q] - *here->value[q]) / kStep_s;
      }
    }
  }

  MixtureComponent linear(const AssignedTimes& one) const {
    MixtureComponent h = component_of(first_, one.weight);
    for (std::size_t k = 0; k < reduction::kQuantityCount; ++k) {
      auto& value = h.value[static_cast<Quantity>(k)];
      if (!value) continue;
      for (std::size_t i = 0; i < slopes_.size(); ++i)
        *value += slopes_[i][k] * (one.time_s[i] - frame_.images[i].time_s);
    }
    return h;
  }

  const Frame& frame_;
  std::span<const AssignedTimes> all_;
  const Readout& first_;
  double linear_s_;
  std::vector<std::array<double, reduction::kQuantityCount>>
      slopes_;  ///< of the numbers by each image's time
};

}  // namespace

Result<Readout> reduce_hypotheses(const Frame& frame, std::span<const AssignedTimes> hypotheses) {
  auto readout = reduction::reduce(frame, reduction::Estimator::best);
  if (readout && !hypotheses.empty()) reduction::mix(Mixing(frame, hypotheses, *readout).run(), *readout);
  return readout;
}

}  // namespace strobe::host
