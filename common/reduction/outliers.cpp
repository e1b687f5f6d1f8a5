#include "common/reduction/outliers.hpp"

#include <cmath>
#include <limits>

#include "common/reduction/scale_check.hpp"
#include "common/reduction/student_t.hpp"
#include "common/reduction/variance_test.hpp"

namespace strobe::reduction {
namespace {

constexpr int kMinImages = 4;
/// A residual variance below this share of the measurement's is rounding: the fit must pass through the
/// measurement, which no other can contradict.
constexpr double kRounding = 1e-9;

struct Suspect {
  double probability = 1.0;  // of so large a deviation by chance, times the number of measurements
  std::size_t image = 0;
  enum class What { centre, diameter, equator } what = What::centre;
};

void consider(Suspect& worst, double probability, double chances, std::size_t image, Suspect::What what) {
  if (probability * chances < worst.probability) worst = {probability * chances, image, what};
}

double freedom(const ShotFit& fit, NoiseGroup noise) {
  if (noise == NoiseGroup::stated) return std::numeric_limits<double>::infinity();
  return fit.variance_components[static_cast<std::size_t>(noise)].degrees_of_freedom;
}

/// Of a square with `dimensions` degrees of freedom, in units of a variance that was estimated with it
/// included: by the variance without it, F.
double chance_of_square(double square, double degrees_of_freedom, int dimensions) {
  if (!std::isfinite(degrees_of_freedom)) {
    return dimensions == 2 ? std::exp(-0.5 * square) : std::erfc(std::sqrt(0.5 * square));
  }
  const double left = degrees_of_freedom - dimensions;
  if (left < 0.5) return 1.0;
  const double rest = (degrees_of_freedom - square) / left;
  if (!(rest > 0.0)) return 0.0;
  if (dimensions == 2)
    return std::pow(1.0 + square / (rest * left), -0.5 * left);  // F(2, left) in closed form
  return student_t_tail(std::sqrt(square / rest), left);
}

/// Squared deviation from the prediction by the other images: the whitened residual r has covariance I - H,
/// H being the share that the image has in its own fitted place.
double deleted_square(const ShotFit& fit, const Observation& o) {
  const ImageRows rows = image_rows(fit.observations, fit.joint, o);
  const auto x = fit.joint.factor.whitened(leg_index(*o.leg), rows.row[0]);
  const auto y = fit.joint.factor.whitened(leg_index(*o.leg), rows.row[1]);
  const double xx = 1.0 - dot(x, x);
  const double xy = -dot(x, y);
  const double yy = 1.0 - dot(y, y);
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > kRounding) || !(xx > kRounding)) return 0.0;
  const double rx = rows.residual[0];
  const double ry = rows.residual[1];
  return (yy * rx * rx - 2.0 * xy * rx * ry + xx * ry * ry) / determinant;
}

void suspect_centres(const ShotFit& fit, Suspect& worst) {
  int count[2] = {0, 0};
  for (const Observation& o : fit.observations.images) {
    if (o.use_centre) ++count[leg_index(*o.leg)];
  }
  for (std::size_t i = 0; i < fit.observations.images.size(); ++i) {
    const Observation& o = fit.observations.images[i];
    if (!o.use_centre || count[leg_index(*o.leg)] < kMinImages) continue;
    const double square = deleted_square(fit, o);
    if (square < 9.0) continue;  // cannot be beyond chance
    consider(worst, chance_of_square(square, freedom(fit, o.centre_noise), 2), count[0] + count[1], i,
             Suspect::What::centre);
  }
}

void suspect_diameters(const ShotFit& fit, Suspect& worst) {
  const MeanDiameter diameters = mean_diameter(fit);
  if (diameters.count < kMinImages) return;
  for (std::size_t i = 0; i < fit.observations.images.size(); ++i) {
    const Observation& o = fit.observations.images[i];
    if (!o.use_diameter) continue;
    const double residual = o.diameter_m - diameters.mean_m;
    const double sd = fit.observations.diameter_sd(o);
    const double variance = sd * sd - 1.0 / diameters.weight;
    const double square = variance > kRounding * sd * sd ? residual * residual / variance : 0.0;
    if (square < 4.0) continue;
    consider(worst, chance_of_square(square, freedom(fit, o.diameter_noise), 1), diameters.count, i,
             Suspect::What::diameter);
  }
}

void suspect_equators(const ShotFit& fit, Suspect& worst) {
  const double chances = static_cast<double>(fit.equators[0].size() + fit.equators[1].size());
  for (std::size_t leg = 0; leg < 2; ++leg) {
    const auto& readings = fit.equators[leg];
    if (!fit.spin[leg] || readings.size() < static_cast<std::size_t>(kMinImages)) continue;
    for (std::size_t i = 0; i < readings.size(); ++i) {
      const double by_time = fit.spin[leg]->omega_radps * readings[i].time_sd_s;
      const double noise = readings[i].sd_rad * readings[i].sd_rad + by_time * by_time;
      const double variance = noise * (1.0 - fit.spin[leg]->leverage[i]);
      const double residual = fit.spin[leg]->residual_rad[i];
      const double square = variance > kRounding * noise ? residual * residual / variance : 0.0;
      if (square < 4.0) continue;
      const NoiseGroup group = readings[i].estimated_noise ? NoiseGroup::equator : NoiseGroup::stated;
      consider(worst, chance_of_square(square, freedom(fit, group), 1), chances, readings[i].index,
               Suspect::What::equator);
    }
  }
}

}  // namespace

bool reject_worst_outlier(ShotFit& fit) {
  Suspect worst;
  worst.probability = kFalseAlarms / 3.0;  // three kinds of measurement share the false alarms
  const double threshold = worst.probability;
  suspect_centres(fit, worst);
  suspect_diameters(fit, worst);
  suspect_equators(fit, worst);
  if (!(worst.probability < threshold)) return false;
  Observation& o = fit.observations.images[worst.image];
  switch (worst.what) {
    case Suspect::What::centre:
      o.use_centre = o.use_diameter = o.use_equator = false;
      break;
    case Suspect::What::diameter:
      o.use_diameter = false;
      break;
    case Suspect::What::equator:
      o.use_equator = false;
      break;
  }
  return true;
}

}  // namespace strobe::reduction
