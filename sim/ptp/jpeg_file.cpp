#include "sim/ptp/jpeg_file.hpp"

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "common/config/files.hpp"

#include <jpeglib.h>

namespace strobe::sim::ptp {

namespace {

constexpr int kQuality = 90;

struct Compressed {
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  ~Compressed() { std::free(bytes); }
};

void compress(const cv::Mat& grey, Compressed& compressed) {
  jpeg_error_mgr errors{};
  jpeg_compress_struct jpeg{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  jpeg_mem_dest(&jpeg, &compressed.bytes, &compressed.size);
  jpeg.image_width = static_cast<JDIMENSION>(grey.cols);
  jpeg.image_height = static_cast<JDIMENSION>(grey.rows);
  jpeg.input_components = 1;
  jpeg.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, kQuality, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  for (int y = 0; y < grey.rows; ++y) {
    auto* row = const_cast<JSAMPLE*>(grey.ptr<JSAMPLE>(y));  // libjpeg only reads it
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
}

}  // namespace

Result<void> write_jpeg(const std::filesystem::path& path, const cv::Mat& pixels, int white) {
  cv::Mat grey;
  pixels.convertTo(grey, CV_8U, pixels.depth() == CV_8U ? 1.0 : 255.0 / white);
  Compressed compressed;
  compress(grey, compressed);
  return config::write_file(
      path, std::string_view(reinterpret_cast<const char*>(compressed.bytes), compressed.size));
}

}  // namespace strobe::sim::ptp
