#include "tests/support/pictures.hpp"

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

}  // namespace

Bytes encoded_picture(const cv::Mat& pixels, const std::string& extension,
                      const image::TiffOptions& options) {
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
  auto raster = image::decode(bytes);
  if (!raster) throw std::runtime_error(path.string() + ": " + raster.error().message);
  const cv::Mat pixels = image::mat_of(*raster);
  if (raster->channels() == 1) return pixels.clone();
  cv::Mat picture;
  cv::cvtColor(pixels, picture, cv::COLOR_RGB2BGR);
  return picture;
}

}  // namespace strobe::testing
