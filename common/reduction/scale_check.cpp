#include "common/reduction/scale_check.hpp"

#include <algorithm>
#include <limits>

#include "common/reduction/variance_test.hpp"

namespace strobe::reduction {
namespace {

double square(double x) { return x * x; }

/// Of the mean diameter, by the errors of the camera's map: images weigh alike, near enough for a test.
double map_variance(const Observations& all) {
  double sum = 0.0;
  for (const ObservedMapError& error : all.map_errors) {
    double shift = 0.0;
    for (const ObservedMapError::Shift& s : error.images) shift += s.diameter_m;
    sum += square(shift / static_cast<double>(std::max<std::size_t>(error.images.size(), 1)));
  }
  return sum;
}

}  // namespace

MeanDiameter mean_diameter(const ShotFit& fit) {
  const Observations& all = fit.observations;
  // Where the calibration is the better known no diameter is used, but all of them were measured.
  const bool any_used =
      std::any_of(all.images.begin(), all.images.end(), [](const Observation& o) { return o.use_diameter; });
  MeanDiameter diameters;
  for (const Observation& o : all.images) {
    if (!(any_used ? o.use_diameter : o.use_centre)) continue;
    const double weight = 1.0 / square(all.diameter_sd(o));
    const double off = o.diameter_m - diameters.mean_m;
    const double both = diameters.weight + weight;
    diameters.sum_of_squares += weight * (diameters.weight / both) * off * off;
    diameters.mean_m += weight / both * off;
    diameters.weight = both;
    ++diameters.count;
    diameters.estimated_noise = diameters.estimated_noise || o.diameter_noise != NoiseGroup::stated;
  }
  return diameters;
}

bool scale_contradicts_ball(const ShotFit& fit) {
  const Observations& all = fit.observations;
  if (!all.scale) return false;
  const MeanDiameter diameters = mean_diameter(fit);
  if (diameters.count == 0) return false;
  double of_mean = 1.0 / diameters.weight;
  double freedom = std::numeric_limits<double>::infinity();
  if (diameters.estimated_noise) {
    freedom = diameters.count - 1.0;
    if (freedom < 1.0) return false;
    of_mean *= diameters.sum_of_squares / freedom;
  }
  const double variance = of_mean + map_variance(all) + square(all.ball_diameter_m * all.scale_sd) +
                          square(*all.scale * all.ball_diameter_sd_m.value_or(0.0));
  if (!(variance > 0.0)) return false;
  // Welch-Satterthwaite: only the mean's variance is an estimate.
  if (of_mean > 0.0) freedom *= square(variance / of_mean);
  const double off = square(diameters.mean_m - *all.scale * all.ball_diameter_m) / variance;
  return off > 9.0 &&
         chance_of_scatter(off, 1.0, freedom) < kFalseAlarms;  // below 3 sd it cannot be beyond chance
}

}  // namespace strobe::reduction
