// From a digitized frame to a readout: the estimators behind one interface.
// Deterministic, no I/O; thread-safe; allocates, so not for the real-time path.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

enum class Estimator {
  best,       ///< every airborne image of a leg, gravity, common scale and surface line, with covariance
  two_point,  ///< slope between the two images nearest to the impact (thesis, tilt corrected), measured times
  legacy,     ///< the thesis's program with its quirks, for comparison with old results
};

constexpr std::optional<Estimator> estimator_from_name(std::string_view text) {
  if (text == "best") return Estimator::best;
  if (text == "two-point") return Estimator::two_point;
  if (text == "legacy") return Estimator::legacy;
  return std::nullopt;
}

/// How to reduce; the defaults are the product's, the rest is for studies. `effects` is for
/// the best estimator; the others know neither gravity nor air.
struct ReduceOptions {
  /// What the flight is fitted with. Absent: gravity, and drag and Magnus where they matter to this shot.
  /// With drag comes the spin's decay, which stays where drag is then left out.
  std::optional<flight::Effects> effects{};
  /// For the best estimator.
  NoiseSource noise = NoiseSource::stated;
  /// Leave out images that do not fit and say so (outlier_image), best estimator only. Without it every image
  /// counts and the readout is a smooth function of the measurements, as studies of small displacements need.
  bool reject_outliers = true;
  /// Give Readout::covariance as well.
  bool covariance = false;
  /// Give Readout::by_time as well.
  bool by_time = false;
  /// Look for Readout::likely_cause where a flag asks for it, for a person: as long as up to some hundred
  /// reductions.
  bool likely_cause = false;
};

/// A readout of the frame. Numbers that cannot be computed are absent and the flags say why.
/// Fails only for a frame that is not one: no positive diameter, a bounce with fewer than two surface points,
/// non-finite coordinates, images out of order of time. The message names the field. Of a frame without a
/// surface only the best estimator gives numbers: Readout::launch.
Result<Readout> reduce(const Frame& frame, Estimator estimator, const ReduceOptions& options = {});

// How each image of a frame stands to what was fitted to all of them: for a person who looks at the
// photograph. Deterministic; thread-safe; allocates; as long as reduce().

struct ImageFit {
  std::optional<Leg> leg;  ///< as the reduction took it
  bool centre_used = false, diameter_used = false, equator_used = false;
  /// From its centre to the fitted path at its time [px]; an image that was left out has one, too. Absent: it
  /// is on no leg that was fitted.
  std::optional<double> residual_px;
};

/// One for each of the frame's images, by the best estimator with stated noise. Fails as reduce() does.
Result<std::vector<ImageFit>> image_fits(const Frame& frame);

}  // namespace strobe::reduction
