#include "sim/photograph/photograph_file.hpp"

#include <cstdint>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <vector>

namespace strobe::sim {

namespace {

constexpr int kNoCompression = 1;  // of TIFF's tag 259
constexpr int kQuickPng = 1;

Result<std::vector<std::uint8_t>> encode(const cv::Mat& pixels, PhotographFormat format) {
  std::vector<int> parameters{cv::IMWRITE_TIFF_COMPRESSION, kNoCompression};
  if (format == PhotographFormat::png) parameters = {cv::IMWRITE_PNG_COMPRESSION, kQuickPng};
  std::vector<std::uint8_t> bytes;
  try {
    if (cv::imencode(extension(format), pixels, bytes, parameters)) return bytes;
  } catch (const cv::Exception& error) {
    return fail("cannot be encoded: " + error.err);
  }
  return fail("cannot be encoded");
}

}  // namespace

std::string extension(PhotographFormat format) { return format == PhotographFormat::png ? ".png" : ".tif"; }

Result<void> write_photograph(const std::filesystem::path& path, const cv::Mat& pixels,
                              PhotographFormat format) {
  const auto bytes = encode(pixels, format);
  if (!bytes) return fail(path.string() + ": " + bytes.error().message);
  const std::filesystem::path part = path.string() + ".part";
  std::ofstream file(part, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes->data()), static_cast<std::streamsize>(bytes->size()));
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(part, path, error);
  if (file && !error) return {};
  std::filesystem::remove(part, error);
  return fail(path.string() + ": cannot be written");
}

}  // namespace strobe::sim
