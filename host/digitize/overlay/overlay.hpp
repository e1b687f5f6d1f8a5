// What was found, drawn on the photograph for a person to check: outlines by leg, equator lines, numbers and
// times, the surface line, and what was rejected with its reason. Deterministic; thread-safe; allocates.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "common/result.hpp"
#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/digitize.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

struct OverlaySettings {
  bool rejected = true;  ///< draw them, too
  /// The picture is made smaller until no side is longer, so that it can be looked at.
  int longest_side_px = 4096;
};

/// 8 bit, blue-green-red, the photograph's size unless that is too large. The photograph is brightened so
/// that what is dark on it can be seen. Images by hand are drawn in magenta.
cv::Mat draw_overlay(const Photograph& photograph, const PlaneMap& map, const Digitization& digitization,
                     const OverlaySettings& settings = {});

/// Writes it as the file's extension says (PNG, TIFF, JPEG). Fails with the file's name.
Result<void> write_overlay(const std::filesystem::path& path, const Photograph& photograph,
                           const PlaneMap& map, const Digitization& digitization,
                           const OverlaySettings& settings = {});

}  // namespace strobe::digitize
