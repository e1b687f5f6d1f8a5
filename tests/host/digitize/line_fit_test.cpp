#include "host/digitize/equator/line_fit.hpp"

#include <cmath>
#include <random>

#include "tests/support/string_from.hpp"

using namespace strobe::digitize;

namespace {

constexpr double kRadius = 65.0;  ///< in bins
constexpr double kNoise = 0.03;
constexpr double kContrast = 0.8;
constexpr LineShape kShape{0.045, 0.013};

/// Two neighbours' limbs run along the line, whose angle is 0: the one hides its upper edge or is within it on one
/// half, the other its lower edge on the other.
struct Limbs {
  double off = 0.0;    ///< from the line's middle, radii
  double ring = 0.02;  ///< half width of what is not used around a limb
  double amiss = 0.0;  ///< share of the neighbours' light that was not subtracted
};

std::vector<LinePoint> points_between(const Limbs& limbs, unsigned seed) {
  constexpr double kOthers = 0.8;  // light over the ball's
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<LinePoint> points;
  for (double v = -0.25; v < 0.25; v += 1.0 / kRadius) {
    for (double u = -0.94; u < 0.95; u += 1.0 / kRadius) {
      const double beyond = (u < 0.0 ? v : -v) - limbs.off;
      if (u * u + v * v > 0.9 || std::abs(beyond) < limbs.ring) continue;
      const double others = beyond > 0.0 ? kOthers : 0.0, variance = 1.0 + others * others;
      const double x = limbs.amiss * others - kContrast * kShape.darkness(v) +
                       kNoise * std::sqrt(variance) * normal(random);
      points.push_back({static_cast<float>(u), static_cast<float>(v),
                        static_cast<float>(std::sqrt(1.0 - u * u - v * v)), static_cast<float>(x),
                        static_cast<float>(1.0 / variance)});
    }
  }
  return points;
}

/// Root of the mean squared error over the stated variance, of lines whose true angle is 0.
double normalized_error(double wider, const Limbs& limbs) {
  constexpr unsigned kTimes = 20;
  double squares = 0.0;
  for (unsigned seed = 1; seed <= kTimes; ++seed) {
    EquatorLine start;
    start.contrast = kContrast;
    start.shape = {kShape.half_width * wider, kShape.soft};
    const auto fit = fit_line(points_between(limbs, seed), kRadius, start, {});
    CHECK_TRUE(fit.has_value());
    const double angle = fit->line.angle_rad;
    squares += angle * angle / (fit->angle_variance * std::max(fit->scatter, fit->expected_scatter));
  }
  return std::sqrt(squares / kTimes);
}

}  // namespace

// Twenty errors of a true sd have an rms of 1 ± 0.16. A width that is off by one of its sds adds as much as it takes
// of the variance, the same in all twenty: at most the root of two, with three of that scatter 1.9.
TEST_GROUP(LineFits) { const Limbs at_the_edge{0.05, 0.035, 0.0}; };

TEST(LineFits, StateATrueSdWhereALimbHidesOneEdgeOnEitherHalf) {
  CHECK_COMPARE(normalized_error(1.0, at_the_edge), <, 1.9);
}

TEST(LineFits, StateATrueSdWhereTheLineIsWiderThanItsShapeAndALimbHidesOneEdge) {
  CHECK_COMPARE(normalized_error(1.0 + ShapeGrid::kHalfWidthSd, at_the_edge), <, 1.9);
  CHECK_COMPARE(normalized_error(1.0 - ShapeGrid::kHalfWidthSd, at_the_edge), <, 1.9);
}

TEST(LineFits, StateATrueSdWhereLimbsAreInTheLineAndTheirLightIsSubtractedAmiss) {
  CHECK_COMPARE(normalized_error(1.0, {0.0, 0.02, 0.1}), <, 1.9);
  CHECK_COMPARE(normalized_error(1.0, {0.0, 0.02, -0.1}), <, 1.9);
}
