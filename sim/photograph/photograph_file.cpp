#include "sim/photograph/photograph_file.hpp"

#include <chrono>
#include <cstdint>
#include <fstream>
#include <vector>

#include "common/image/image_files.hpp"
#include "common/image/opencv.hpp"

namespace strobe::sim {

namespace {

Result<std::vector<std::uint8_t>> encode(const cv::Mat& pixels, PhotographFormat format) {
  const bool known = pixels.type() == CV_8UC1 || pixels.type() == CV_16UC1;
  if (!known) return fail("cannot be encoded");
  const image::Pixels grey = image::pixels_of(pixels);
  return format == PhotographFormat::png ? image::encode_png(grey) : image::encode_tiff(grey);
}

}  // namespace

std::string extension(PhotographFormat format) { return format == PhotographFormat::png ? ".png" : ".tif"; }

Result<void> write_photograph(const std::filesystem::path& path, const cv::Mat& pixels,
                              PhotographFormat format, std::optional<WallTime> written) {
  const auto bytes = encode(pixels, format);
  if (!bytes) return fail(path.string() + ": " + bytes.error().message);
  const std::filesystem::path part = path.string() + ".part";
  std::ofstream file(part, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes->data()), static_cast<std::streamsize>(bytes->size()));
  file.close();
  std::error_code error;
  if (written) std::filesystem::last_write_time(part, std::chrono::file_clock::from_sys(*written), error);
  if (file && !error) std::filesystem::rename(part, path, error);
  if (file && !error) return {};
  std::filesystem::remove(part, error);
  return fail(path.string() + ": cannot be written");
}

}  // namespace strobe::sim
