// The path of a ball that goes straight down and up. Deterministic; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

/// The legs become those of the images in the air, all on one line, from the highest: the way down and the way up
/// with each image's flash, or one leg that is not told apart.
void take_drop_images(std::span<const PathPoint> points, std::vector<int> images, const PathContext& context,
                      Path& path);

}  // namespace strobe::digitize
