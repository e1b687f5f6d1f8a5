#include "tests/support/pictures.hpp"

#include <bit>
#include <fstream>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "common/image/opencv.hpp"

namespace strobe::testing {

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes value_of(Result<Bytes> bytes) {
  if (!bytes) throw std::runtime_error(bytes.error().message);
  return *bytes;
}

void append(Bytes& bytes, const std::string& text) { bytes.insert(bytes.end(), text.begin(), text.end()); }

Bytes pgm(const cv::Mat& grey) {
  Bytes bytes;
  const bool wide = grey.depth() == CV_16U;
  append(bytes, "P5\n" + std::to_string(grey.cols) + " " + std::to_string(grey.rows) + "\n" +
                    (wide ? "65535" : "255") + "\n");
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      const unsigned number = wide ? grey.at<std::uint16_t>(y, x) : grey.at<std::uint8_t>(y, x);
      if (wide) bytes.push_back(static_cast<std::uint8_t>(number >> 8));
      bytes.push_back(static_cast<std::uint8_t>(number));
    }
  }
  return bytes;
}

void append_number(Bytes& bytes, std::uint32_t number, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(number >> 8 * i));
}

/// Rows from the bottom, with a palette of greys.
Bytes bmp(const cv::Mat& grey) {
  constexpr std::uint32_t kHeaders = 54, kPalette = 4 * 256;
  const auto width = static_cast<std::uint32_t>(grey.cols), row = (width + 3) / 4 * 4;
  Bytes bytes{'B', 'M'};
  append_number(bytes, kHeaders + kPalette + row * static_cast<std::uint32_t>(grey.rows), 4);
  append_number(bytes, 0, 4);
  append_number(bytes, kHeaders + kPalette, 4);
  append_number(bytes, 40, 4);
  append_number(bytes, width, 4);
  append_number(bytes, static_cast<std::uint32_t>(grey.rows), 4);
  append_number(bytes, 1, 2);
  append_number(bytes, 8, 2);
  for (int i = 0; i < 6; ++i) append_number(bytes, 0, 4);
  for (std::uint32_t i = 0; i < 256; ++i) append_number(bytes, i * 0x010101, 4);
  for (int y = grey.rows - 1; y >= 0; --y) {
    bytes.insert(bytes.end(), grey.ptr(y), grey.ptr(y) + width);
    bytes.resize(bytes.size() + row - width);
  }
  return bytes;
}

}  // namespace

Bytes encoded_picture(const cv::Mat& pixels, const std::string& extension,
                      const image::TiffOptions& options) {
  if (extension == ".pgm") return pgm(pixels);
  if (extension == ".bmp") return bmp(pixels);
  cv::Mat colours = pixels;
  if (pixels.channels() == 3) cv::cvtColor(pixels, colours, cv::COLOR_BGR2RGB);
  const image::Pixels view = image::pixels_of(colours);
  if (extension == ".jpg") return value_of(image::encode_jpeg(view));
  if (extension == ".png") return value_of(image::encode_png(view));
  return value_of(image::encode_tiff(view, options));
}

void write_picture(const std::filesystem::path& path, const cv::Mat& pixels) {
  const Bytes bytes = encoded_picture(pixels, path.extension().string());
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

cv::Mat read_picture(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  auto raster = path.extension() == ".png" ? image::decode_png(bytes) : image::decode_tiff(bytes);
  if (!raster) throw std::runtime_error(path.string() + ": " + raster.error().message);
  const cv::Mat pixels = image::mat_of(*raster);
  if (raster->channels() == 1) return pixels.clone();
  cv::Mat picture;
  cv::cvtColor(pixels, picture, cv::COLOR_RGB2BGR);
  return picture;
}

}  // namespace strobe::testing
