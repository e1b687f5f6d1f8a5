// A camera's RAW file, as DNG 1.4 (Adobe). Thread-safe; allocates; nothing printed.
#pragma once

#include <cstdint>
#include <vector>

#include "common/image/raster.hpp"
#include "common/result.hpp"

namespace strobe::sim {

/// Of one number of 16 bits a pixel, uncompressed.
Result<std::vector<std::uint8_t>> encode_dng(const image::Pixels& pixels, const image::Mosaic& mosaic);

}  // namespace strobe::sim
