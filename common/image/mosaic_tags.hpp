// The tags of a TIFF page that describe a mosaic; for the reader and the writer of TIFF in this folder.
#pragma once

#include <tiffio.h>

#include <optional>

#include "common/image/raster.hpp"

namespace strobe::image {

/// Returns nullopt where one is lacking or says what no Mosaic can.
std::optional<Mosaic> read_mosaic_tags(TIFF* tiff);

/// Returns false if libtiff refuses one.
bool write_mosaic_tags(TIFF* tiff, const Mosaic& mosaic);

}  // namespace strobe::image
