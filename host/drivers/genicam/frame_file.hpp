// From a frame in memory to a photograph in a folder. Thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "host/drivers/genicam/pixel_format.hpp"

namespace strobe::genicam {

/// As it came from the camera: what it says of itself need not be true.
struct Frame {
  std::uint32_t pixel_format = 0;  ///< PFNC's code
  int width = 0, height = 0;       ///< pixels
  int row_padding = 0;             ///< bytes after each row
  std::span<const std::uint8_t> bytes;
};

/// An uncompressed TIFF file in two parts, so that pixels go to the disk from where the camera put them: a
/// library's copies take three times as long as the disk.
struct TiffFile {
  std::vector<std::uint8_t> start;
  std::span<const std::uint8_t> pixels;  ///< of the frame, or `unpacked`
  std::vector<std::uint8_t> unpacked;
};

/// The sensor's own numbers: grey of 8 or 16 bits, or a colour sensor's mosaic (common/image). Numbers of 10
/// to 14 bits are not scaled. Fails for a format that is not understood, and where the bytes are too few for
/// what the frame says it is.
Result<TiffFile> tiff_of(const Frame& frame);

/// Puts a file into the folder, at once whole, under this name or, where that is taken, the next that is
/// free; the time of its last change is `ended`, when the exposure did. Returns the name. Fails with the
/// file's name and the system's reason.
Result<std::string> put_file(const std::filesystem::path& folder, const std::string& stem,
                             const TiffFile& tiff, WallTime ended);

}  // namespace strobe::genicam
