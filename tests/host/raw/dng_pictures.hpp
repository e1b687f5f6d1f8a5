// A small DNG file, and strobe-raw run on one.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "common/image/image_files.hpp"
#include "sim/photograph/dng.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/program_run.hpp"

namespace strobe::testing {

inline constexpr int kRawWidth = 64, kRawHeight = 48;
inline const image::Mosaic kRawMosaic{{0, 1, 1, 2}, 200, 4095};

inline void set_number(image::Raster& raster, int x, int y, int number) {
  const auto value = static_cast<std::uint16_t>(number);
  std::memcpy(raster.row(y) + 2 * x, &value, 2);
}

inline int raw_number(const image::Raster& raster, int x, int y) {
  std::uint16_t value = 0;
  std::memcpy(&value, raster.row(y) + 2 * x, 2);
  return value;
}

/// Slopes, another in each colour, with a little noise.
inline image::Raster raw_picture() {
  image::Raster raster(kRawWidth, kRawHeight, 1, 16);
  for (int y = 0; y < kRawHeight; ++y)
    for (int x = 0; x < kRawWidth; ++x)
      set_number(raster, x, y, 400 + 11 * x + 7 * y + 300 * kRawMosaic.colour(x, y) + (31 * x + 17 * y) % 13);
  return raster;
}

inline std::string dng_of(const image::Raster& raster, const image::Mosaic& mosaic = kRawMosaic) {
  const auto bytes = sim::encode_dng(raster.pixels(), mosaic);
  return {bytes->begin(), bytes->end()};
}

inline std::string raw_program() { return std::string(STROBE_BUILD_DIR) + "/bin/strobe-raw"; }

/// What it makes of a file's bytes.
inline Result<image::Raster> converted(const TemporaryFolder& folder, const std::string& file) {
  write_text(folder / "a.dng", file);
  const auto run = run_program({raw_program(), folder / "a.dng", folder / "a.tif"});
  if (run.status->code != 0) return fail(run.err);
  CHECK_EQUAL("", run.out + run.err);
  const std::string tiff = read_text(folder / "a.tif");
  return image::decode({reinterpret_cast<const unsigned char*>(tiff.data()), tiff.size()});
}

}  // namespace strobe::testing
