// How a camera says it was held.
#pragma once

#include "common/image/image_files.hpp"

namespace strobe::image {

/// Tag 0x0112 of EXIF (CIPA DC-008): 1 to 8. `exif` begins with the TIFF header, "II" or "MM". Returns 1 if it
/// says nothing that can be read.
int exif_orientation(Bytes exif);

}  // namespace strobe::image
