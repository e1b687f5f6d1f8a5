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
constexpr double kMinShare = 0.001;

/// Of a short train's light over the other one's: less is not chance, and whether light adds up is left open.
constexpr double kWhole = 0.85;

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
  if (means.share < kMinShare)
    return fail(
        "hardly anything in the view is lit by the lamps: stand a white sheet of paper where balls fly");
  // A, B and both flash at the same instants: however much of the exposure is cut off, this is the dark.
  const double dark = means.a + means.b - means.both;
  const double of_early = (means.early - dark) / p.early.flashes,
               of_late = (means.late - dark) / p.late.flashes;
  const double whole = std::max(of_early, of_late);
  light.early = whole > 0.0 ? of_early / whole : 1.0;
  light.late = whole > 0.0 ? of_late / whole : 1.0;
  light.dark = dark;
  light.a = (means.a - dark) / p.of_a.flashes, light.b = (means.b - dark) / p.of_b.flashes;
  if (std::min(light.early, light.late) < kWhole) return light;
  // Of A, of B and of the short trains: three equations for a, b and the dark, of which both make a fourth.
  const double flashes_of_short = 0.5 * (p.early.flashes + p.late.flashes);
  Eigen::Matrix3d flashes;
  flashes << p.of_a.flashes, 0.0, 1.0, 0.0, p.of_b.flashes, 1.0, flashes_of_short, flashes_of_short, 1.0;
  const Eigen::Vector3d solved =
      flashes.partialPivLu().solve(Eigen::Vector3d(means.a, means.b, 0.5 * (means.early + means.late)));
  light.a = solved[0], light.b = solved[1], light.dark = solved[2];
  const double of_both = means.both - light.dark;
  light.excess = of_both > 0.0 ? 1.0 - p.of_both.flashes * (light.a + light.b) / of_both : 0.0;
  return light;
}

}  // namespace strobe::commission
