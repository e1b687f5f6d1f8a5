#include "tests/studies/design/noise_ratios.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

namespace strobe::studies::design {

namespace {

constexpr double kMaxStatedSds = 5.0;
constexpr int kMinImagesOfGroup = 3;
/// A surface known worse, over the diameter, may be either edge of the plate.
constexpr double kOneEdge = 0.01;

struct Measured {
  double error = 0.0, stated_sd = 0.0, predicted_sd = 0.0;
};

std::optional<NoiseGroup> group_of(NoiseKind kind, const std::vector<Measured>& all) {
  NoiseGroup group{.kind = kind, .images = static_cast<int>(all.size())};
  if (group.images < kMinImagesOfGroup) return std::nullopt;
  const double n = group.images;
  double sum = 0.0, mean = 0.0, weights2 = 0.0, information = 0.0;
  for (const Measured& m : all) sum += 1.0 / (m.stated_sd * m.stated_sd);
  const auto weight = [&](const Measured& m) { return 1.0 / (m.stated_sd * m.stated_sd * sum); };
  for (const Measured& m : all) mean += weight(m) * m.error;
  for (const Measured& m : all) {
    const double most = kMaxStatedSds * m.stated_sd, w2 = weight(m) * weight(m);
    const double own = std::clamp(m.error - mean, -most, most);
    group.measured += n * w2 * own * own;
    information += 1.0 / (m.predicted_sd * m.predicted_sd);
    weights2 += w2;
  }
  // One image that outweighs all others tells nothing.
  if (weights2 >= 0.9) return std::nullopt;
  group.measured /= 1.0 - weights2;
  group.stated = n / sum;
  group.predicted = n / information;
  group.common = mean * mean - group.measured / n;
  return group;
}

using MeasuredOf = std::function<std::optional<Measured>(const NoiseSample&, const host::DigitizerSds&)>;

std::vector<Measured> measured(const NoisePhotograph& photograph, std::optional<bool> rebound,
                               const MeasuredOf& of) {
  std::vector<Measured> all;
  for (const NoiseSample& s : photograph.images) {
    if (!s.found || (rebound && s.rebound != *rebound)) continue;
    const auto sds = host::digitizer_sds(s.picture);
    if (!sds) continue;
    const auto one = of(s, *sds);
    if (one && one->stated_sd > 0.0) all.push_back(*one);
  }
  return all;
}

/// The lowest points of all balls over the line.
std::optional<NoiseGroup> surface_of(const NoisePhotograph& photograph) {
  const auto lowest =
      measured(photograph, std::nullopt, [](const NoiseSample& s, const host::DigitizerSds& sds) {
        return Measured{s.lowest_px, s.centre_sd_px, sds.surface_px};
      });
  if (!photograph.surface_px || lowest.size() < kMinImagesOfGroup) return std::nullopt;
  if (photograph.surface_sd_px > kOneEdge * photograph.condition.diameter_px) return std::nullopt;
  double mean_px = 0.0, sum = 0.0;
  for (const Measured& m : lowest) {
    mean_px += m.error / (m.stated_sd * m.stated_sd);
    sum += 1.0 / (m.stated_sd * m.stated_sd);
  }
  const double most_px = kMaxStatedSds * photograph.surface_sd_px / std::sqrt(host::kSurfacePoints);
  const double height_px = std::clamp(mean_px / sum - *photograph.surface_px, -most_px, most_px);
  return NoiseGroup{.kind = NoiseKind::surface,
                    .images = 1,
                    .measured = host::kSurfacePoints * height_px * height_px,
                    .predicted = lowest.front().predicted_sd * lowest.front().predicted_sd,
                    .stated = photograph.surface_sd_px * photograph.surface_sd_px};
}

std::optional<Measured> along(const NoiseSample& s, const host::DigitizerSds& sds) {
  return Measured{s.along_px, s.centre_sd_px, sds.centre_along_px};
}
std::optional<Measured> across(const NoiseSample& s, const host::DigitizerSds& sds) {
  return Measured{s.across_px, s.centre_sd_px, sds.centre_across_px};
}
std::optional<Measured> diameter(const NoiseSample& s, const host::DigitizerSds& sds) {
  return Measured{s.diameter_px, s.diameter_sd_px, sds.diameter_px};
}
std::optional<Measured> equator(const NoiseSample& s, const host::DigitizerSds& sds) {
  if (!s.equator_rad) return std::nullopt;
  return Measured{*s.equator_rad, s.equator_sd_rad, sds.equator_rad};
}

double root(double sum, int count) {
  return count > 0 ? std::sqrt(std::max(0.0, sum) / count) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::vector<NoiseGroup> noise_groups(const NoisePhotograph& photograph) {
  std::vector<NoiseGroup> groups;
  const auto add = [&](const std::optional<NoiseGroup>& group) {
    if (group) groups.push_back(*group);
  };
  for (const bool rebound : {false, true}) {
    add(group_of(NoiseKind::along, measured(photograph, rebound, along)));
    add(group_of(NoiseKind::across, measured(photograph, rebound, across)));
    add(group_of(NoiseKind::equator, measured(photograph, rebound, equator)));
  }
  add(group_of(NoiseKind::diameter, measured(photograph, std::nullopt, diameter)));
  add(surface_of(photograph));
  return groups;
}

void NoiseRatio::add(const NoiseGroup& group) {
  const auto over = [&](double variance) {
    return group.images * std::clamp(variance / group.predicted, -kMaxExcess, kMaxExcess);
  };
  images_ += group.images;
  ++groups_;
  if (group.measured > kMaxExcess * group.predicted) ++excessive_;
  measured_ += over(group.measured);
  stated_ += over(group.stated);
  common_ += over(group.common);
}

double NoiseRatio::measured() const { return root(measured_, images_); }
double NoiseRatio::stated() const { return root(stated_, images_); }
double NoiseRatio::common() const { return root(common_, images_); }

void NoiseScore::add(const NoisePhotograph& photograph) {
  ++photographs;
  invented += photograph.invented;
  for (const NoiseGroup& group : noise_groups(photograph))
    ratios[static_cast<std::size_t>(group.kind)].add(group);
  for (const NoiseSample& s : photograph.images) {
    const auto sds = host::digitizer_sds(s.picture);
    if (!sds) {
      ++unknown;
      continue;
    }
    ++images.of;
    images.predicted += sds->found;
    if (!s.found) continue;
    ++images.found;
    ++equators.of;
    equators.predicted += sds->equator_found;
    if (s.equator_rad) ++equators.found;
  }
}

}  // namespace strobe::studies::design
