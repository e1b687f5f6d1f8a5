// Image files of strangers: any bytes are a picture within its limits or an error of one line, in each of the
// readers; and a picture comes back as it was written.
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "common/image/image_files.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;
using namespace strobe::image;

namespace {

void require_same(const Raster& written, const strobe::Result<std::vector<std::uint8_t>>& bytes,
                  strobe::Result<Raster> (*decode)(Bytes)) {
  require(bytes.has_value());
  const auto read = decode(*bytes);
  require(read.has_value() && read->size_bytes() == written.size_bytes());
  require(read->width() == written.width() && read->channels() == written.channels());
  require(std::memcmp(read->row(0), written.row(0), written.size_bytes()) == 0);
}

void try_reader(strobe::Result<Raster> (*decode)(Bytes), Bytes bytes) {
  constexpr std::int64_t kMaxWritten = 10'000;  // larger ones only cost rounds
  const auto raster = decode(bytes);
  if (!raster) return require_one_line(raster.error().message, "");
  require(raster->width() > 0 && raster->height() > 0);
  require(std::int64_t{raster->width()} * raster->height() <= kMaxPixels);
  require(raster->orientation >= 1 && raster->orientation <= 8);
  if (std::int64_t{raster->width()} * raster->height() > kMaxWritten) return;
  require_same(*raster, encode_png(raster->pixels()), decode_png);
  require_same(*raster, encode_tiff(raster->pixels(), {.lzw = true}), decode_tiff);
  if (!raster->mosaic) return;
  require(raster->mosaic->is_valid() && !is_camera_raw(bytes));
  const auto again = encode_tiff(raster->pixels(), {.mosaic = raster->mosaic});
  require_same(*raster, again, decode_tiff);
  require(decode_tiff(*again)->mosaic == raster->mosaic);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes bytes(data, size);
  for (const auto reader : {decode, decode_tiff, decode_jpeg, decode_png}) try_reader(reader, bytes);
  is_camera_raw(bytes);
  return 0;
}
