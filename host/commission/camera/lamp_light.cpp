#include "host/commission/camera/lamp_light.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

namespace strobe::commission {
namespace {

/// Over the dark: eight steps of an 8-bit file, so that rounding averages out.
constexpr float kLit = 0.03F;
/// Of the pixels: 5,000 of 5 million, whose noise is then below a thousandth.
constexpr double kLeastShare = 0.001;

/// Means over the pixels that are lit in the photograph of both lamps and saturated in none.
struct Means {
  double a = 0.0, b = 0.0, both = 0.0, early = 0.0, late = 0.0;
  double share = 0.0;
};

Means means_of(const LampPhotographs& p) {
  const std::array<const digitize::Photograph*, 5> all{
      &p.of_a.photograph, &p.of_b.photograph, &p.of_both.photograph, &p.early.photograph, &p.late.photograph};
  std::array<double, 5> sums{};
  std::size_t pixels = 0;
  const int rows = all[0]->height(), columns = all[0]->width();
  for (int row = 0; row < rows; ++row) {
    std::array<const float*, 5> line{};
    for (std::size_t k = 0; k < all.size(); ++k) line[k] = all[k]->intensity.ptr<float>(row);
    for (int column = 0; column < columns; ++column) {
      const auto value = [&](std::size_t k) { return line[k][column]; };
      if (value(2) - std::min(value(3), value(4)) < kLit) continue;
      bool clipped = false;
      for (std::size_t k = 0; k < all.size(); ++k) clipped = clipped || value(k) >= all[k]->saturation;
      if (clipped) continue;
      for (std::size_t k = 0; k < all.size(); ++k) sums[k] += static_cast<double>(value(k));
      ++pixels;
    }
  }
  Means means;
  means.share = static_cast<double>(pixels) / (static_cast<double>(rows) * columns);
  if (pixels == 0) return means;
  const auto n = static_cast<double>(pixels);
  means.a = sums[0] / n, means.b = sums[1] / n, means.both = sums[2] / n;
  means.early = sums[3] / n, means.late = sums[4] / n;
  return means;
}

}  // namespace

Result<LampLight> measure_lamp_light(const LampPhotographs& p) {
  for (const LitPhotograph* other : {&p.of_b, &p.of_both, &p.early, &p.late}) {
    if (other->photograph.intensity.size() != p.of_a.photograph.intensity.size())
      return fail("the photographs differ in size");
  }
  const Means means = means_of(p);
  LampLight light;
  light.lit_share = means.share;
  if (means.share < kLeastShare)
    return fail(
        "hardly anything in the view is lit by the lamps: stand a white sheet of paper where balls fly");
  // Of A, of B and of the better half of the two short trains: three equations for a, b and the dark.
  const bool early_better = means.early >= means.late;
  const LitPhotograph& half = early_better ? p.early : p.late;
  Eigen::Matrix3d flashes;
  flashes << p.of_a.flashes, 0.0, 1.0, 0.0, p.of_b.flashes, 1.0, half.flashes, half.flashes, 1.0;
  const Eigen::Vector3d seen(means.a, means.b, early_better ? means.early : means.late);
  const Eigen::Vector3d solved = flashes.partialPivLu().solve(seen);
  light.a = solved[0], light.b = solved[1], light.dark = solved[2];
  const double of_both = means.both - light.dark;
  light.excess = of_both > 0.0 ? 1.0 - p.of_both.flashes * (light.a + light.b) / of_both : 0.0;
  // The dark from all three long trains, where light adds up.
  const double dark = std::abs(light.excess) < 0.05 ? means.a + means.b - means.both : light.dark;
  const auto share = [&](double mean, const LitPhotograph& of) {
    const double expected = (means.both - dark) * of.flashes / p.of_both.flashes;
    return expected > 0.0 ? (mean - dark) / expected : 0.0;
  };
  light.early = share(means.early, p.early);
  light.late = share(means.late, p.late);
  return light;
}

}  // namespace strobe::commission
