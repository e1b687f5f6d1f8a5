#include "host/digitize/image/photograph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "common/image/image_files.hpp"
#include "common/image/opencv.hpp"
#include "host/digitize/image/mosaic_light.hpp"
#include "host/external/raw_file.hpp"

namespace strobe::digitize {

namespace {

constexpr int kMinSide = 16;

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return text;
}

/// Grey of 8 or 16 bits. The pixels lie in `raster`, or in `grey` itself.
struct Decoded {
  image::Raster raster;
  cv::Mat grey;
  int step = 1;  ///< between numbers that the file may have
};

/// How far numbers are apart: of 12 bits at the top of 16 by 16, of 8 spread over 16 by 257.
int step_of(const cv::Mat& pixels) {
  constexpr int kSpread = 257;
  if (pixels.depth() == CV_8U) return 1;
  unsigned any = 0;
  bool spread = true;
  for (int y = 0; y < pixels.rows; ++y) {
    const auto* row = pixels.ptr<std::uint16_t>(y);
    for (int x = 0; x < pixels.cols * pixels.channels(); ++x) {
      if (row[x] == 65535) continue;  // full, or dead
      any |= row[x];
      spread = spread && row[x] % kSpread == 0;
      if (!spread && (any & 1U) != 0) return 1;
    }
  }
  if (any == 0) return 1;
  return spread ? kSpread : 1 << std::min(8, std::countr_zero(any));
}

/// That numbers from 0 to `range` fill.
int bits_of(double range, int step) {
  return std::clamp(static_cast<int>(std::ceil(std::log2(range / step))), 8, 16);
}

/// Of light of which one colour is cut off the sum is not known: it counts as saturated, as a mosaic's does.
void fill_where_a_colour_is_full(const cv::Mat& colours, cv::Mat& grey) {
  cv::Mat strongest, colour;
  cv::extractChannel(colours, strongest, 0);
  for (int c = 1; c < colours.channels(); ++c) {
    cv::extractChannel(colours, colour, c);
    cv::max(strongest, colour, strongest);
  }
  double top = 0.0;  // below the range's end where a file has fewer bits
  cv::minMaxLoc(strongest, nullptr, &top);
  grey.setTo(top, strongest >= saturation_level(strongest));
}

Result<Decoded> decode_grey(std::span<const unsigned char> bytes) {
  auto raster = image::decode(bytes);
  if (!raster) return tl::unexpected(raster.error());
  if (raster->width() < kMinSide || raster->height() < kMinSide)
    return fail(fmt::format("{} x {} pixels are too few: {} x {} are needed", raster->width(),
                            raster->height(), kMinSide, kMinSide));
  const cv::Mat pixels = image::mat_of(*raster);
  const int step = step_of(pixels);
  if (raster->channels() == 1) return Decoded{std::move(*raster), pixels, step};  // a mosaic, too
  Decoded decoded;
  decoded.step = step;
  cv::cvtColor(pixels, decoded.grey, cv::COLOR_RGB2GRAY);
  fill_where_a_colour_is_full(pixels, decoded.grey);
  decoded.raster.orientation = raster->orientation;
  return decoded;
}

constexpr int kBins = 256;
/// Width to which compression or a full well spreads the peak of saturated pixels: 3 % of the range.
constexpr int kPeakBins = 8;
/// A saturated sensor's numbers reach at least this share of what its bits can hold.
constexpr double kMinTop = 0.85;

/// Counts of each number on every step-th row and column.
template <typename Number>
std::vector<std::int32_t> histogram(const cv::Mat& pixels, int step) {
  std::vector<std::int32_t> counts(std::size_t{std::numeric_limits<Number>::max()} + 1);
  for (int y = 0; y < pixels.rows; y += step) {
    const auto* row = pixels.ptr<Number>(y);
    for (int x = 0; x < pixels.cols; x += step) ++counts[row[x]];
  }
  return counts;
}

std::array<std::int64_t, kBins> binned(const std::vector<std::int32_t>& counts, int bin_width) {
  std::array<std::int64_t, kBins> bins{};
  for (std::size_t n = 0; n < counts.size(); ++n)
    bins[std::min(n / static_cast<std::size_t>(bin_width), std::size_t{kBins - 1})] += counts[n];
  return bins;
}

/// What a sensor's bits can hold: the fewest that reach `largest`.
int range_of(double largest, double file_range) {
  for (const int bits : {10, 12, 14})
    if (file_range > 256 && largest < (1 << bits)) return 1 << bits;
  return static_cast<int>(file_range);
}

/// The lowest bin of the peak at the top of a histogram whose last filled bin is `top`. Returns nullopt if
/// the counts fall off towards it, as those of an unsaturated picture do.
std::optional<int> bottom_of_peak(const std::array<std::int64_t, kBins>& counts, int top) {
  const auto at = [&](int bin) { return counts[static_cast<std::size_t>(bin)]; };
  std::int64_t in_peak = 0, below = 0;
  int highest = top;
  for (int bin = top; bin > top - kPeakBins; --bin) {
    in_peak += at(bin);
    below += at(bin - kPeakBins);
    if (at(bin) > at(highest)) highest = bin;
  }
  constexpr std::int64_t kMinCount = 20;
  if (in_peak < kMinCount || in_peak < 4 * below) return std::nullopt;
  int low = highest;
  while (low > top - kPeakBins && 20 * at(low - 1) > at(highest)) --low;
  return low;
}

Result<Photograph> decoded(std::span<const unsigned char> bytes, const std::string& name) {
  if (bytes.size() > static_cast<std::size_t>(INT32_MAX)) return fail("the file is larger than 2 GB");
  const auto decoded = decode_grey(bytes);
  if (!decoded) return tl::unexpected(decoded.error());
  const cv::Mat& grey = decoded->grey;
  Photograph photograph;
  photograph.name = name;
  photograph.orientation = decoded->raster.orientation;
  if (const auto& mosaic = decoded->raster.mosaic) {
    auto [light, saturation] =
        mosaic_light(grey, *mosaic, std::min<double>(mosaic->white, saturation_level(grey)));
    photograph.intensity = std::move(light);
    photograph.saturation = saturation;
    photograph.bits = bits_of(mosaic->white - mosaic->black, decoded->step);
    return photograph;
  }
  const double top = grey.depth() == CV_8U ? 255.0 : 65535.0;
  photograph.bits = bits_of(top, decoded->step);
  // Half a number less, so that no saturated pixel is missed by rounding.
  photograph.saturation = static_cast<float>((saturation_level(grey) - 0.5) / top);
  photograph.intensity.create(grey.size(), CV_32FC1);
  cv::parallel_for_(cv::Range(0, grey.rows), [&](const cv::Range& rows) {
    cv::Mat intensity = photograph.intensity.rowRange(rows);
    grey.rowRange(rows).convertTo(intensity, CV_32F, 1.0 / top);
  });
  return photograph;
}

}  // namespace

double saturation_level(const cv::Mat& pixels) {
  const bool bytes = pixels.depth() == CV_8U;
  const double file_range = bytes ? 256.0 : 65536.0;
  // Half a million pixels are enough to see a peak.
  const int step = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(pixels.total()) / 5e5)));
  const auto numbers = bytes ? histogram<std::uint8_t>(pixels, step) : histogram<std::uint16_t>(pixels, step);
  std::size_t largest = numbers.size() - 1;
  while (largest > 0 && numbers[largest] == 0) --largest;
  const int range = range_of(static_cast<double>(largest), file_range);
  if (static_cast<double>(largest) < kMinTop * range) return file_range - 1;
  const int width = range / kBins;
  const auto peak = bottom_of_peak(binned(numbers, width), static_cast<int>(largest) / width);
  return peak ? *peak * width : file_range - 1;
}

Photograph enlarged(const Photograph& photograph, int factor) {
  Photograph larger = photograph;
  const cv::Size size(photograph.width() * factor, photograph.height() * factor);
  larger.intensity = cv::Mat();
  cv::resize(photograph.intensity, larger.intensity, size, 0, 0, cv::INTER_CUBIC);
  cv::Mat saturated;
  cv::resize(photograph.intensity >= photograph.saturation, saturated, size, 0, 0, cv::INTER_NEAREST);
  // Cubics swing over beside an edge.
  cv::min(larger.intensity, std::nextafter(photograph.saturation, 0.0F), larger.intensity);
  cv::max(larger.intensity, 0.0, larger.intensity);
  larger.intensity.setTo(photograph.saturation, saturated);
  return larger;
}

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
  if (!std::filesystem::exists(status)) return fail(fmt::format("{}: no such file", name));
  // Opening a pipe would wait for whoever fills it.
  if (!std::filesystem::is_regular_file(status)) return fail(fmt::format("{}: not a regular file", name));
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return fail(fmt::format("{}: cannot be opened", name));
  const std::streamoff size = file.tellg();
  if (size < 0 || size > INT32_MAX) return fail(fmt::format("{}: is larger than 2 GB", name));
  const auto count = static_cast<std::size_t>(size);
  const auto bytes = std::make_unique_for_overwrite<unsigned char[]>(count);
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.get()), size);
  if (file.gcount() != size) return fail(fmt::format("{}: cannot be read to its end", name));
  if (!external::is_raw_name(path) && !image::is_camera_raw({bytes.get(), count}))
    return decode_photograph({bytes.get(), count}, name);
  const auto mosaic = external::mosaic_of_raw_file(path);
  if (!mosaic) return fail(fmt::format("{}: {}", name, mosaic.error().message));
  return decode_photograph(*mosaic, name);
}

}  // namespace strobe::digitize
