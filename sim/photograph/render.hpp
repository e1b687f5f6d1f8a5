// Renders the photograph of one exposure, with the truth about it. Light adds up: the background is lit by
// every flash; a ball adds its own light at its flash and hides the background for that one flash:
//   I = sum over flashes of B_k + sum over images of (S_k - B_k) within the ball's outline,
// then blurred by the lens, vignetted, and developed with noise to the file's bits. Of a mosaic each pixel
// has its own colour's share of that (sim/photograph/colours.hpp).
//
// Deterministic for any number of threads: the same scene, exposure and appearance give the same numbers.
// Thread-safe; allocates (some 60 MB for 5 megapixels); uses OpenCV's threads.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/image/raster.hpp"
#include "common/result.hpp"
#include "common/units/time.hpp"
#include "sim/photograph/appearance.hpp"
#include "sim/photograph/lit_balls.hpp"
#include "sim/rig/exposure.hpp"
#include "sim/scene/photograph_settings.hpp"

namespace strobe::sim {

/// Photographs have at most this many pixels.
inline constexpr double kMaxPixels = 120e6;

struct Photograph {
  cv::Mat pixels;                       ///< rows from the top; CV_8UC1 for 8 bits, else CV_16UC1
  std::optional<image::Mosaic> mosaic;  ///< of the formats that have one
  PhotographTruth truth;
};

/// Fails for a sensor that is too large. `appearance`: of draw_appearance(), possibly changed.
Result<Photograph> render(const Scene& scene, const Exposure& exposure, const Appearance& appearance);

/// With draw_appearance() of that shot.
Result<Photograph> render(const Scene& scene, std::uint64_t seed, const Exposure& exposure);

// From light on the sensor to pixel values: lens blur, vignetting, shot and read noise, saturation,
// bits. Deterministic for any number of threads; allocates.

/// Blurs light (CV_32FC1) in place: the disc of a point out of focus, and the lens's own blur.
void blur(cv::Mat& light, double blur_px, double defocus_px);

/// Numbers of light (1 saturates): CV_8UC1 for 8 bits, else CV_16UC1.
cv::Mat develop(const cv::Mat& light, const PhotographSettings& settings, const Appearance& appearance);

// Photographs as files, written as a tethered camera does: under a temporary name without an image's
// extension, then renamed. Thread-safe for different files; writes files.

/// ".tif", ".png" or ".dng"
std::string extension(PhotographFormat format);

/// `mosaic`: of those formats. The file appears complete under its name, over an older one. `written`: its
/// time of last change, the machine's if none is given. The error names the file.
Result<void> write_photograph(const std::filesystem::path& path, const cv::Mat& pixels,
                              PhotographFormat format, std::optional<WallTime> written = std::nullopt,
                              const std::optional<image::Mosaic>& mosaic = std::nullopt);

}  // namespace strobe::sim
