// Draws a digitization on its photograph for inspection: outlines by leg, equator lines, numbers and times,
// the surface line, and where asked what was rejected, with the reason. Deterministic; thread-safe;
// allocates.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "common/result.hpp"
#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/digitize.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

// A photograph's light as a screen shows it. Pure; thread-safe; allocates.

/// CV_8UC1 of Photograph::intensity: black and white at the 1st and 99.8th percentile, with a gamma of 0.5,
/// so that dark parts are visible. white: the number that white becomes, up to 255.
cv::Mat display_grey(const cv::Mat& intensity, double white = 255.0);

struct OverlaySettings {
  bool rejected = false;  ///< draw what was rejected, too, with the reason
  /// Larger photographs are downsampled.
  int longest_side_px = 4096;
};

/// CV_8UC3 (BGR), the photograph's size unless downsampled. Intensities are stretched so that dark parts are
/// visible. Images measured by hand are magenta.
cv::Mat draw_overlay(const Photograph& photograph, const PlaneMap& map, const Digitization& digitization,
                     const OverlaySettings& settings = {});

/// Writes it as the file's extension says (PNG, TIFF, JPEG). Fails with the file's name.
Result<void> write_overlay(const std::filesystem::path& path, const Photograph& photograph,
                           const PlaneMap& map, const Digitization& digitization,
                           const OverlaySettings& settings = {});

}  // namespace strobe::digitize
