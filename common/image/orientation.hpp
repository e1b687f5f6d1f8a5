// Pictures turned as TIFF's tag Orientation says.
#pragma once

#include "common/image/raster.hpp"

namespace strobe::image {

/// The first row and column of `stored` are what TIFF 6.0 says of `orientation`, 1 to 8. From 5 on, width and
/// height are exchanged.
Raster turned(const Raster& stored, int orientation);

}  // namespace strobe::image
