#include "host/drivers/raw/raw_file.hpp"

#include <fmt/format.h>
#include <libraw/libraw.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/image/image_files.hpp"
#include "host/drivers/raw/defects.hpp"

namespace strobe::raw {

namespace {

std::string camera_of(const LibRaw& file) {
  const auto& camera = file.imgdata.idata;
  std::string name = fmt::format("{} {}", camera.make, camera.model);
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
  return name.size() > 1 ? name : "camera";
}

/// Why its numbers are not those of single pixels behind colours in tiles of 2 x 2, or behind none. LibRaw's
/// `filters`: 9 is X-Trans, 0 none, otherwise the pattern, of 2 x 2 from 1000 on.
std::optional<std::string> unsuitable(LibRaw& file) {
  const auto& camera = file.imgdata.idata;
  const auto& decoded = file.imgdata.rawdata;
  constexpr unsigned kXTrans = 9, kFirstBayer = 1000;
  if (decoded.float_image || decoded.float3_image || decoded.float4_image)
    return "holds floating-point numbers, no sensor's";
  if (camera.is_foveon) return "is a Foveon sensor's: its pixels see all colours at once";
  if (decoded.color3_image || decoded.color4_image)
    return "holds mixed colours in place of the sensor's numbers (sRAW, mRAW, linear or lossy DNG): set the "
           "camera to its full RAW format";
  if (camera.filters == kXTrans) return "has an X-Trans mosaic, which is not read: save it as a 16-bit TIFF";
  if (!decoded.raw_image) return "holds no numbers of a sensor";
  if (camera.filters == 0 && camera.colors == 1) return std::nullopt;
  if (camera.filters < kFirstBayer) return "has a mosaic that is not of 2 x 2 pixels";
  if (file.imgdata.sizes.pixel_aspect != 1.0 || decoded.ioparams.fuji_width != 0)
    return "has pixels that are not on a square grid (Super CCD)";
  return std::nullopt;
}

/// Returns nullopt if no red, green, green and blue repeat.
std::optional<image::Mosaic> mosaic_of(LibRaw& file) {
  image::Mosaic mosaic;
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 4; ++column) {
      const char name = file.imgdata.idata.cdesc[file.COLOR(row, column)];
      const auto colour = static_cast<std::uint8_t>(name == 'R' ? 0 : name == 'G' ? 1 : name == 'B' ? 2 : 3);
      auto& known = mosaic.colours[static_cast<std::size_t>(row % 2 * 2 + column % 2)];
      if (row < 2 && column < 2)
        known = colour;
      else if (known != colour)
        return std::nullopt;
    }
  }
  return mosaic.is_valid() ? std::optional(mosaic) : std::nullopt;
}

/// What the sensor shows in the dark: of all pixels, of a colour, and of a place in a repeating pattern.
int black_of(LibRaw& file, int row, int column) {
  const auto& colour = file.imgdata.color;
  unsigned black = colour.black + colour.cblack[file.COLOR(row, column)];
  const unsigned rows = colour.cblack[4], columns = colour.cblack[5];
  if (rows > 0 && columns > 0 && rows * columns <= LIBRAW_CBLACK_SIZE - 6)
    black += colour.cblack[6 + static_cast<unsigned>(row) % rows * columns +
                           static_cast<unsigned>(column) % columns];
  return static_cast<int>(std::min(black, 65535U));
}

struct Levels {
  int least_black = 65535, most_black = 0, white = 65535;
};

Levels levels_of(LibRaw& file) {
  constexpr int kPeriod = 16;  // patterns of black levels are of 2 x 2, rarely more
  Levels levels;
  for (int row = 0; row < kPeriod; ++row) {
    for (int column = 0; column < kPeriod; ++column) {
      levels.least_black = std::min(levels.least_black, black_of(file, row, column));
      levels.most_black = std::max(levels.most_black, black_of(file, row, column));
    }
  }
  if (const unsigned most = file.imgdata.color.maximum; most > 0 && most < 65535)
    levels.white = static_cast<int>(most);
  return levels;
}

/// Of the visible area, as if all pixels had the black level `black`.
void copy_pixels(LibRaw& file, int black, image::Raster& raster) {
  const auto& sizes = file.imgdata.sizes;
  for (int row = 0; row < raster.height(); ++row) {
    const auto* from = reinterpret_cast<const std::uint16_t*>(
                           reinterpret_cast<const char*>(file.imgdata.rawdata.raw_image) +
                           std::size_t{sizes.raw_pitch} * static_cast<std::size_t>(row + sizes.top_margin)) +
                       sizes.left_margin;
    auto* to = reinterpret_cast<std::uint16_t*>(raster.row(row));
    constexpr int kPeriod = 48;  // columns after which each pattern has come round
    std::array<int, kPeriod> change{};
    for (int column = 0; column < kPeriod; ++column)
      change[static_cast<std::size_t>(column)] = black - black_of(file, row, column);
    for (int column = 0; column < raster.width(); ++column)
      to[column] = static_cast<std::uint16_t>(
          std::clamp(from[column] + change[static_cast<std::size_t>(column % kPeriod)], 0, 65535));
  }
}

/// LibRaw's versions differ in the offset's type.
template <typename Offset>
void on_damage(void* seen, const char*, Offset) {
  *static_cast<bool*>(seen) = true;
}

Result<void> unpack(LibRaw& file, const std::string& path, bool& damaged) {
  file.set_dataerror_handler(on_damage, &damaged);
  const auto failed = [](int status) {
    return fail(status == LIBRAW_IO_ERROR ? "it cannot be read, or is cut short" : LibRaw::strerror(status));
  };
  if (const int status = file.open_file(path.c_str()); status != LIBRAW_SUCCESS) {
    if (status == LIBRAW_FILE_UNSUPPORTED)
      return fail("not a RAW file that LibRaw " LIBRAW_VERSION_STR " knows");
    return failed(status);
  }
  const auto& sizes = file.imgdata.sizes;
  const std::int64_t pixels = std::int64_t{sizes.raw_width} * sizes.raw_height;
  if (pixels <= 0 || pixels > image::kMaxPixels)
    return fail(fmt::format("{} x {} pixels are more than the {} million that are read", sizes.raw_width,
                            sizes.raw_height, image::kMaxPixels / 1'000'000));
  if (const int status = file.unpack(); status != LIBRAW_SUCCESS) {
    if (status == LIBRAW_FILE_UNSUPPORTED || status == LIBRAW_REQUEST_FOR_NONEXISTENT_IMAGE)
      return fail(fmt::format("the file of a {} is compressed in a way that LibRaw {} does not know",
                              camera_of(file), LIBRAW_VERSION_STR));
    return failed(status);
  }
  if (damaged) return fail("its pixels are damaged");
  if (sizes.width < 2 || sizes.height < 2 || sizes.left_margin + sizes.width > sizes.raw_width ||
      sizes.top_margin + sizes.height > sizes.raw_height)
    return fail("its header is damaged");
  return {};
}

}  // namespace

Result<image::Raster> read_raw_file(const std::string& path) {
  const auto file = std::make_unique<LibRaw>(LIBRAW_OPTIONS_NONE);
  bool damaged = false;
  if (auto done = unpack(*file, path, damaged); !done) return tl::unexpected(done.error());
  if (const auto why = unsuitable(*file))
    return fail(fmt::format("the file of a {} {}", camera_of(*file), *why));
  image::Raster raster(file->imgdata.sizes.width, file->imgdata.sizes.height, 1, 16);
  const Levels levels = levels_of(*file);
  const bool grey = file->imgdata.idata.filters == 0;
  const int black = grey ? 0 : levels.least_black;
  const int white = levels.white - levels.most_black + black;
  if (white <= black) return fail("its header is damaged: black is not darker than white");
  copy_pixels(*file, black, raster);
  if (!grey) {
    raster.mosaic = mosaic_of(*file);
    if (!raster.mosaic)
      return fail(
          fmt::format("the file of a {} has other colours than red, green and blue", camera_of(*file)));
    raster.mosaic->black = black;
    raster.mosaic->white = white;
  }
  mend_pixels(raster, black, white);
  return raster;
}

}  // namespace strobe::raw
