// Pixels that do not see: dead, hot or stuck. Pure; thread-safe; allocates.
#pragma once

#include "common/image/raster.hpp"

namespace strobe::raw {

/// Mends each pixel that stands alone beyond its eight nearest of the same colour, above all or below all, by
/// more than twice their spread and 2 % of the range from black to white: no lens draws anything so small,
/// and no noise of the neighbours' size reaches so far. Its number becomes the mean of those two opposite
/// neighbours that differ least. Of a mosaic, or grey with neighbours side by side. Returns how many.
int mend_pixels(image::Raster& raster, int black, int white);

}  // namespace strobe::raw
