// libjpeg leaves its functions on errors by longjmp: those that call setjmp hold nothing that needs a
// destructor.
#include <cstddef>
#include <cstdio>
// jpeglib.h wants FILE and size_t.
#include <jpeglib.h>

#include <csetjmp>
#include <cstdlib>
#include <cstring>
// jerror.h wants jpeglib.h.
#include <jerror.h>

#include "common/image/checks.hpp"
#include "common/image/image_files.hpp"

namespace strobe::image {

namespace {

/// What libjpeg is given first, so that its pointer is one to the whole.
struct Errors {
  jpeg_error_mgr manager{};
  std::jmp_buf back{};
  char words[JMSG_LENGTH_MAX] = "";
};

[[noreturn]] void leave(j_common_ptr info) {
  auto* errors = reinterpret_cast<Errors*>(info->err);
  info->err->format_message(info, errors->words);
  std::longjmp(errors->back, 1);
}

/// Warnings are what libjpeg goes on after with guessed pixels, but for bytes between segments, which belong
/// to none, and Adobe's marker of an unknown kind.
void on_message(j_common_ptr info, int level) {
  if (level >= 0) return;
  const int code = info->err->msg_code;
  if (code != JWRN_EXTRANEOUS_DATA && code != JWRN_ADOBE_XFORM) leave(info);
}

jpeg_error_mgr* handler(Errors& errors) {
  jpeg_std_error(&errors.manager);
  errors.manager.error_exit = leave;
  errors.manager.emit_message = on_message;
  return &errors.manager;
}

/// A progressive file of many scans takes time without end. Programs write some ten; the standard allows
/// three components 64 coefficients of 14 bits each, which none does.
void count_scans(j_common_ptr info) {
  constexpr int kMaxScans = 500;
  auto* errors = reinterpret_cast<Errors*>(info->err);
  if (reinterpret_cast<j_decompress_ptr>(info)->input_scan_number <= kMaxScans) return;
  std::snprintf(errors->words, sizeof errors->words, "more than %d scans", kMaxScans);
  std::longjmp(errors->back, 1);
}

class JpegReader {
 public:
  explicit JpegReader(Bytes bytes) : bytes_(bytes) {}
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() { jpeg_destroy_decompress(&info_); }

  bool read_header() {
    info_.err = handler(errors_);
    if (setjmp(errors_.back) != 0) return false;
    jpeg_create_decompress(&info_);
    jpeg_mem_src(&info_, bytes_.data(), static_cast<unsigned long>(bytes_.size()));
    jpeg_save_markers(&info_, JPEG_APP0 + 1, 0xFFFF);
    jpeg_read_header(&info_, TRUE);
    return true;
  }
  std::int64_t width() const { return info_.image_width; }
  std::int64_t height() const { return info_.image_height; }
  int channels() const { return info_.num_components > 1 ? 3 : 1; }
  bool is_arithmetic() const { return info_.arith_code != FALSE; }

  bool read_pixels(Raster& raster) {
    if (setjmp(errors_.back) != 0) return false;
    progress_.progress_monitor = count_scans;
    info_.progress = &progress_;
    const bool inks = info_.num_components == 4;
    info_.out_color_space = inks ? JCS_CMYK : raster.channels() == 3 ? JCS_RGB : JCS_GRAYSCALE;
    jpeg_start_decompress(&info_);
    JSAMPARRAY row = info_.mem->alloc_sarray(reinterpret_cast<j_common_ptr>(&info_), JPOOL_IMAGE,
                                             4 * info_.output_width, 1);
    for (int y = 0; y < raster.height(); ++y) {
      JSAMPROW to = inks ? row[0] : raster.row(y);
      jpeg_read_scanlines(&info_, &to, 1);
      if (inks) colours_of_inks(row[0], raster.row(y), raster.width());
    }
    jpeg_finish_decompress(&info_);
    return true;
  }
  int orientation() const {
    constexpr std::size_t kName = 6;  // "Exif", two zeros
    for (auto* marker = info_.marker_list; marker != nullptr; marker = marker->next)
      if (marker->data_length > kName && std::memcmp(marker->data, "Exif\0\0", kName) == 0)
        return exif_orientation({marker->data + kName, marker->data_length - kName});
    return 1;
  }
  const char* words() const { return errors_.words; }

 private:
  /// Adobe's CMYK: 255 is no ink.
  static void colours_of_inks(const std::uint8_t* inks, std::uint8_t* colours, int width) {
    for (int x = 0; x < width; ++x, inks += 4, colours += 3)
      for (int c = 0; c < 3; ++c)
        colours[c] = static_cast<std::uint8_t>(inks[3] - ((255 - inks[c]) * inks[3] >> 8));
  }

  Bytes bytes_;
  Errors errors_;
  jpeg_decompress_struct info_{};
  jpeg_progress_mgr progress_{};
};

class JpegWriter {
 public:
  JpegWriter() = default;
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;
  ~JpegWriter() {
    jpeg_destroy_compress(&info_);
    std::free(bytes_);
  }

  bool write(const Pixels& pixels, int quality) {
    info_.err = handler(errors_);
    if (setjmp(errors_.back) != 0) return false;
    jpeg_create_compress(&info_);
    jpeg_mem_dest(&info_, &bytes_, &size_);
    info_.image_width = static_cast<JDIMENSION>(pixels.width);
    info_.image_height = static_cast<JDIMENSION>(pixels.height);
    info_.input_components = pixels.channels;
    info_.in_color_space = pixels.channels == 3 ? JCS_RGB : JCS_GRAYSCALE;
    jpeg_set_defaults(&info_);
    jpeg_set_quality(&info_, quality, TRUE);
    jpeg_start_compress(&info_, TRUE);
    for (int y = 0; y < pixels.height; ++y) {
      JSAMPROW row = const_cast<JSAMPROW>(pixels.row(y));  // libjpeg only reads it
      jpeg_write_scanlines(&info_, &row, 1);
    }
    jpeg_finish_compress(&info_);
    return true;
  }
  std::vector<std::uint8_t> bytes() const { return {bytes_, bytes_ + size_}; }
  const char* words() const { return errors_.words; }

 private:
  Errors errors_;
  jpeg_compress_struct info_{};
  unsigned char* bytes_ = nullptr;
  unsigned long size_ = 0;
};

}  // namespace

Result<Raster> decode_jpeg(Bytes bytes) {
  JpegReader reader(bytes);
  if (!reader.read_header()) return damaged("JPEG", reader.words());
  if (auto checked = check_size("JPEG", reader.width(), reader.height()); !checked)
    return tl::unexpected(checked.error());
  // Huffman's code takes a bit or more for each block of 8 x 8 pixels: so much must be there before memory is
  // taken.
  constexpr std::int64_t kMaxPixelsOfAByte = 8 * 64;
  if (!reader.is_arithmetic() &&
      reader.width() * reader.height() / kMaxPixelsOfAByte > static_cast<std::int64_t>(bytes.size()))
    return damaged("JPEG", "its pixels are not all there");
  Raster raster(static_cast<int>(reader.width()), static_cast<int>(reader.height()), reader.channels(), 8);
  raster.orientation = reader.orientation();  // libjpeg forgets it with the last row
  if (!reader.read_pixels(raster)) return damaged("JPEG", reader.words());
  return raster;
}

Result<std::vector<std::uint8_t>> encode_jpeg(const Pixels& pixels, int quality) {
  if (auto checked = check_pixels(pixels, 8); !checked) return tl::unexpected(checked.error());
  JpegWriter writer;
  if (!writer.write(pixels, quality)) return fail(fmt::format("cannot be encoded ({})", writer.words()));
  return writer.bytes();
}

}  // namespace strobe::image
