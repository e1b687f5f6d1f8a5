// A ball that falls and rises along one line: which of its images are of the way down and which of the way
// up, from the times of the flashes alone. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

/// An image in the air, on the line.
struct DropImage {
  double height_px = 0.0;  ///< of the centre above the surface
  double sd_px = 0.0;
};

struct StraightDrop {
  struct Flight {
    std::vector<int> image;   ///< in order of time
    std::vector<int> flash;   ///< of each image
    double touch_s = 0.0;     ///< touchdown or lift-off
    double speed_pxps = 0.0;  ///< then, > 0
  };
  Flight down, up;
  std::vector<int> doubled;  ///< outlines of two images at nearly one place: of neither flight
  std::vector<double>
      off_px;  ///< for each image how far it is from the nearest place where a flash saw the ball
};

/// The two flights that explain the most images and leave the fewest of their own unseen. Returns nullopt
/// unless they are a thousand times likelier than flights of other speeds; each has two images or more.
std::optional<StraightDrop> split_drop(std::span<const DropImage> images, const PathContext& context);

// The path of a ball that goes straight down and up. Deterministic; thread-safe; allocates.

/// The legs become those of the images in the air, all on one line, from the highest: the way down and the
/// way up with each image's flash, or one leg that is not told apart.
void take_drop_images(std::span<const PathPoint> points, std::vector<int> images, const PathContext& context,
                      Path& path);

}  // namespace strobe::digitize
