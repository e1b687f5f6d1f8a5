// Renders the photograph of one exposure, with the truth about it. Light adds up: the background is lit by
// every flash; a ball adds its own light at its flash and hides the background for that one flash:
//   I = sum over flashes of B_k + sum over images of (S_k - B_k) within the ball's outline,
// then blurred by the lens, vignetted, and developed with noise to the file's bits.
//
// Deterministic for any number of threads: the same scene, exposure and appearance give the same numbers.
// Thread-safe; allocates (some 60 MB for 5 megapixels); uses OpenCV's threads.
#pragma once

#include <opencv2/core.hpp>

#include "common/result.hpp"
#include "sim/photograph/appearance.hpp"
#include "sim/photograph/photograph_truth.hpp"
#include "sim/rig/exposure.hpp"

namespace strobe::sim {

/// Photographs have at most this many pixels.
inline constexpr double kMaxPixels = 120e6;

struct Photograph {
  cv::Mat pixels;  ///< rows from the top; CV_8UC1 for 8 bits, CV_16UC1 for 12 and 16
  PhotographTruth truth;
};

/// Fails for a sensor that is too large. `appearance`: of draw_appearance(), possibly changed.
Result<Photograph> render(const Scene& scene, const Exposure& exposure, const Appearance& appearance);

/// With draw_appearance() of that shot.
Result<Photograph> render(const Scene& scene, std::uint64_t seed, const Exposure& exposure);

}  // namespace strobe::sim
