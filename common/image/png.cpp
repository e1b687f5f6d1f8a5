// libpng leaves its functions on errors by longjmp: those that call setjmp hold nothing that needs a
// destructor.
#include <png.h>

#include <bit>
#include <cstdio>
#include <cstring>

#include "common/image/checks.hpp"
#include "common/image/image_files.hpp"

namespace strobe::image {

namespace {

struct Words {
  char text[200] = "";
};

[[noreturn]] void on_error(png_structp png, png_const_charp words) {
  std::snprintf(static_cast<Words*>(png_get_error_ptr(png))->text, sizeof(Words::text), "%s", words);
  png_longjmp(png, 1);
}
void on_warning(png_structp, png_const_charp) {}

class PngReader {
 public:
  explicit PngReader(Bytes bytes) : rest_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &words_, on_error, on_warning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) throw std::bad_alloc();
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  bool read_header() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, &rest_, give);
    png_read_info(png_, info_);
    return true;
  }
  std::int64_t width() const { return png_get_image_width(png_, info_); }
  std::int64_t height() const { return png_get_image_height(png_, info_); }
  int bits() const { return png_get_bit_depth(png_, info_) == 16 ? 16 : 8; }
  int channels() const { return (png_get_color_type(png_, info_) & PNG_COLOR_MASK_COLOR) != 0 ? 3 : 1; }
  std::uint64_t file_row_bytes() const { return png_get_rowbytes(png_, info_); }

  bool read_pixels(Raster& raster) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    if (png_get_color_type(png_, info_) == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if (png_get_bit_depth(png_, info_) < 8) png_set_expand_gray_1_2_4_to_8(png_);
    png_set_strip_alpha(png_);
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    const int passes = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    if (png_get_rowbytes(png_, info_) != raster.row_bytes()) png_error(png_, "rows of another length");
    for (int pass = 0; pass < passes; ++pass)
      for (int y = 0; y < raster.height(); ++y) png_read_row(png_, raster.row(y), nullptr);
    png_read_end(png_, info_);
    return true;
  }
  int orientation() {
    png_bytep exif = nullptr;
    png_uint_32 size = 0;
    if (png_get_eXIf_1(png_, info_, &size, &exif) == 0 || exif == nullptr) return 1;
    return exif_orientation({exif, size});
  }
  const char* words() const { return words_.text; }

 private:
  static void give(png_structp png, png_bytep to, std::size_t count) {
    auto& rest = *static_cast<Bytes*>(png_get_io_ptr(png));
    if (count > rest.size()) png_error(png, "it ends too early");
    std::memcpy(to, rest.data(), count);
    rest = rest.subspan(count);
  }

  Words words_;
  Bytes rest_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

class PngWriter {
 public:
  PngWriter() {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, &words_, on_error, on_warning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) throw std::bad_alloc();
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }

  bool write(const Pixels& pixels) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_write_fn(png_, &bytes_, take, [](png_structp) {});
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(pixels.width), static_cast<png_uint_32>(pixels.height),
                 pixels.bits, pixels.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    constexpr int kQuickest = 1, kRunLengths = 3;  // zlib's Z_BEST_SPEED, Z_RLE
    png_set_compression_level(png_, kQuickest);
    png_set_compression_strategy(png_, kRunLengths);
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_write_info(png_, info_);
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    for (int y = 0; y < pixels.height; ++y) png_write_row(png_, pixels.row(y));
    png_write_end(png_, info_);
    return true;
  }
  std::vector<std::uint8_t>& bytes() { return bytes_; }
  const char* words() const { return words_.text; }

 private:
  static void take(png_structp png, png_bytep from, std::size_t count) {
    auto& bytes = *static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(png));
    bool taken = true;
    try {
      bytes.insert(bytes.end(), from, from + count);
    } catch (const std::exception&) {  // none may pass through libpng
      taken = false;
    }
    if (!taken) png_error(png, "no memory");
  }

  Words words_;
  std::vector<std::uint8_t> bytes_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

/// Deflate packs at most this many bytes into one (zlib's technical details: 1032:1).
constexpr std::uint64_t kMaxPacked = 1032;

}  // namespace

Result<Raster> decode_png(Bytes bytes) {
  PngReader reader(bytes);
  if (!reader.read_header()) return damaged("PNG", reader.words());
  if (auto checked = check_size("PNG", reader.width(), reader.height()); !checked)
    return tl::unexpected(checked.error());
  // Before memory is taken for what cannot be there.
  if (reader.file_row_bytes() * static_cast<std::uint64_t>(reader.height()) / kMaxPacked > bytes.size())
    return damaged("PNG", "its pixels are not all there");
  Raster raster(static_cast<int>(reader.width()), static_cast<int>(reader.height()), reader.channels(),
                reader.bits());
  if (!reader.read_pixels(raster)) return damaged("PNG", reader.words());
  raster.orientation = reader.orientation();
  return raster;
}

Result<std::vector<std::uint8_t>> encode_png(const Pixels& pixels) {
  if (auto checked = check_pixels(pixels); !checked) return tl::unexpected(checked.error());
  PngWriter writer;
  if (!writer.write(pixels)) return fail(fmt::format("cannot be encoded ({})", writer.words()));
  return std::move(writer.bytes());
}

}  // namespace strobe::image
