// A TIFF file in memory, open for libtiff; for the readers and writers of TIFF in this folder. Not
// thread-safe.
#pragma once

#include <tiffio.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/image/image_files.hpp"

namespace strobe::image {

/// What libtiff reads or writes; it says what is wrong through it and prints nothing.
struct TiffMemory {
  Bytes bytes;                         ///< of a file that is read
  std::vector<std::uint8_t>* written;  ///< of a file that is written, else null
  std::uint64_t at = 0;
  std::string words = {};   ///< what libtiff said first is wrong
  bool lost_a_tag = false;  ///< libtiff goes on without one whose values are cut off, as a palette
};

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using OpenTiff = std::unique_ptr<TIFF, CloseTiff>;

/// Null if the header is damaged. `memory` outlives what is returned.
OpenTiff open_tiff(TiffMemory& memory);

}  // namespace strobe::image
