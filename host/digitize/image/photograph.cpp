#include "host/digitize/image/photograph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "host/digitize/image/image_header.hpp"
#include "host/digitize/image/saturation.hpp"

namespace strobe::digitize {

namespace {

constexpr int kMinSide = 16;

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return text;
}

Result<ImageHeader> acceptable_header(std::span<const unsigned char> bytes) {
  auto header = read_image_header(bytes);
  if (!header) return header;
  // A quotient, as a product of what a header may say overflows.
  if (header->width > kMaxPixels / header->height)
    return fail(fmt::format("{} x {} pixels are more than the {} million that are read", header->width,
                            header->height, kMaxPixels / 1'000'000));
  if (header->width < kMinSide || header->height < kMinSide)
    return fail(fmt::format("{} x {} pixels are too few: {} x {} are needed", header->width, header->height,
                            kMinSide, kMinSide));
  return header;
}

/// Grey of 8 or 16 bits, as the file has it; it may lie in `bytes`.
Result<cv::Mat> decode_grey(std::span<const unsigned char> bytes, const ImageHeader& header) {
  // OpenCV takes no const buffer, though it only reads it.
  auto* data = const_cast<unsigned char*>(bytes.data());
  if (header.raw_offset) {
    const cv::Mat plain(static_cast<int>(header.height), static_cast<int>(header.width),
                        header.bits == 8 ? CV_8UC1 : CV_16UC1, data + *header.raw_offset);
    if (!header.negative) return plain;
    cv::Mat positive;
    cv::bitwise_not(plain, positive);
    return positive;
  }
  const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8UC1, data);
  cv::Mat pixels = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
  if (pixels.empty()) return fail(fmt::format("the {} file is damaged", header.format));
  if (pixels.cols != header.width || pixels.rows != header.height)
    return fail(fmt::format("the {} header says {} x {} pixels, but {} x {} were read", header.format,
                            header.width, header.height, pixels.cols, pixels.rows));
  if (pixels.depth() != CV_8U && pixels.depth() != CV_16U)
    return fail(fmt::format("the {}'s pixels are of {} bits: 1, 8 or 16 bits unsigned are read",
                            header.format, header.bits));
  if (header.negative) cv::bitwise_not(pixels, pixels);
  cv::Mat grey;
  if (pixels.channels() == 1) return pixels;
  if (pixels.channels() == 3)
    cv::cvtColor(pixels, grey, cv::COLOR_BGR2GRAY);
  else if (pixels.channels() == 4)
    cv::cvtColor(pixels, grey, cv::COLOR_BGRA2GRAY);
  else
    return fail(fmt::format("a pixel of {} numbers is neither grey nor a colour", pixels.channels()));
  return grey;
}

Result<Photograph> decoded(std::span<const unsigned char> bytes, const std::string& name) {
  if (bytes.size() > static_cast<std::size_t>(INT32_MAX)) return fail("the file is larger than 2 GB");
  const auto header = acceptable_header(bytes);
  if (!header) return tl::unexpected(header.error());
  const auto grey = decode_grey(bytes, *header);
  if (!grey) return tl::unexpected(grey.error());
  Photograph photograph;
  photograph.name = name;
  photograph.bits = header->bits == 1 ? 1 : grey->depth() == CV_8U ? 8 : 16;
  const double top = grey->depth() == CV_8U ? 255.0 : 65535.0;
  // Half a number less, so that rounding hides no saturated pixel.
  photograph.saturation = static_cast<float>((saturation_level(*grey) - 0.5) / top);
  photograph.light.create(grey->size(), CV_32FC1);
  cv::parallel_for_(cv::Range(0, grey->rows), [&](const cv::Range& rows) {
    cv::Mat light = photograph.light.rowRange(rows);
    grey->rowRange(rows).convertTo(light, CV_32F, 1.0 / top);
  });
  return photograph;
}

}  // namespace

Result<Photograph> decode_photograph(std::span<const unsigned char> bytes, const std::string& name) {
  try {
    auto photograph = decoded(bytes, name);
    if (!photograph) return fail(fmt::format("{}: {}", name, photograph.error().message));
    return photograph;
  } catch (const std::exception& error) {  // cv::Exception, bad_alloc
    return fail(fmt::format("{}: cannot be decoded: {}", name, one_line(error.what())));
  }
}

Result<Photograph> load_photograph(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return fail(fmt::format("{}: is not there", name));
  // Opening a pipe would wait for whoever fills it.
  if (!std::filesystem::is_regular_file(status)) return fail(fmt::format("{}: is no plain file", name));
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return fail(fmt::format("{}: cannot be opened", name));
  const std::streamoff size = file.tellg();
  if (size < 0 || size > INT32_MAX) return fail(fmt::format("{}: is larger than 2 GB", name));
  const auto count = static_cast<std::size_t>(size);
  const auto bytes = std::make_unique_for_overwrite<unsigned char[]>(count);
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.get()), size);
  if (file.gcount() != size) return fail(fmt::format("{}: cannot be read to its end", name));
  return decode_photograph({bytes.get(), count}, name);
}

}  // namespace strobe::digitize
