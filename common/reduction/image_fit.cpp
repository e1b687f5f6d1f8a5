#include "common/reduction/image_fit.hpp"

#include <cmath>

#include "common/reduction/reduced_shot.hpp"

namespace strobe::reduction {
namespace {

/// Rows are residuals divided by the Cholesky factor of the noise: multiplied by it they are metres again.
std::optional<double> path_residual_px(const ShotFit& fit, const Observation& image) {
  if (!image.leg || *image.leg == Leg::contact || !fit.joint.legs[leg_index(*image.leg)].fitted)
    return std::nullopt;
  const ImageRows rows = image_rows(fit.observations, fit.joint, image);
  const double x = rows.residual[0] / rows.white[0];
  const double y = (rows.residual[1] - rows.white[1] * x) / rows.white[2];
  const double residual_px = std::hypot(x, y) * fit.observations.surface.px_per_unit;
  return std::isfinite(residual_px) ? std::optional(residual_px) : std::nullopt;
}

}  // namespace

Result<std::vector<ImageFit>> image_fits(const Frame& frame) {
  const auto shot = reduce_shot(frame, Estimator::best);
  if (!shot) return tl::unexpected(shot.error());
  std::vector<ImageFit> fits(frame.images.size());
  if (!shot->fit || shot->fit->observations.images.size() != fits.size()) return fits;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const Observation& image = shot->fit->observations.images[i];
    fits[i] = {image.leg, image.use_centre, image.use_diameter, image.use_equator,
               path_residual_px(*shot->fit, image)};
  }
  return fits;
}

}  // namespace strobe::reduction
