// The images of a frame put in order of time, each with its leg and, where the flashes are known, its time.
// Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/digitize.hpp"
#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

/// Orders images and their outlines (as many), from the centres and the frame's surface line, if it has one.
/// A leg that an image already names is kept. Sets time_s and flash_index from settings.flash_times_s;
/// without them, or with fewer flashes than images, times are not-a-number. What was assumed is added to
/// remarks.
void order_images(reduction::Frame& frame, std::vector<Outline>& outlines, const DigitizeSettings& settings,
                  std::vector<std::string>& remarks);

/// The outlines as points of a path, in the surface's axes if there is one.
std::vector<PathPoint> path_points(std::span<const Outline> outlines,
                                   const std::optional<SurfaceLine>& surface);

/// Median diameter, 0 without outlines.
double median_diameter(std::span<const Outline> outlines);

}  // namespace strobe::digitize
