// How each image of a frame stands to what was fitted to all of them: for a person who looks at the photograph.
// Deterministic; thread-safe; allocates; as long as reduce().
#pragma once

#include <optional>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

struct ImageFit {
  std::optional<Leg> leg;  ///< as the reduction took it
  bool centre_used = false, diameter_used = false, equator_used = false;
  /// From its centre to the fitted path at its time [px]; an image that was left out has one, too. Absent: it is on no leg
  /// that was fitted.
  std::optional<double> residual_px;
};

/// One for each of the frame's images, by the best estimator with stated noise. Fails as reduce() does.
Result<std::vector<ImageFit>> image_fits(const Frame& frame);

}  // namespace strobe::reduction
