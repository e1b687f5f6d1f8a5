// A camera's RAW file by LibRaw: the sensor's own numbers, without demosaicing, white balance, rotation or
// lens correction. Reads the file; prints nothing; not thread-safe.
#pragma once

#include <string>

#include "common/image/raster.hpp"
#include "common/result.hpp"

namespace strobe::raw {

/// The visible area. A Bayer sensor's has a mosaic, with one black level for all of its colours (the file's
/// own by colour and place are subtracted; noise in the dark is not cut off); that of a sensor without
/// colours is grey, from 0. Pixels that do not see are mended (defects.hpp).
///
/// Fails with one line for what is no RAW file, damaged, too large, or holds no numbers of single pixels.
Result<image::Raster> read_raw_file(const std::string& path);

}  // namespace strobe::raw
