#include "host/digitize/image/saturation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace strobe::digitize {

namespace {

constexpr int kBins = 256;
/// As wide as compression or a well's spread makes the heap, in bins: 3 % of the range.
constexpr int kHeapBins = 8;
/// A sensor's numbers end at no less than this share of what its bits can hold.
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

}  // namespace

double saturation_level(const cv::Mat& pixels) {
  const bool bytes = pixels.depth() == CV_8U;
  const double file_range = bytes ? 256.0 : 65536.0;
  // Half a million pixels are enough to see a heap.
  const int step = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(pixels.total()) / 5e5)));
  const auto numbers = bytes ? histogram<std::uint8_t>(pixels, step) : histogram<std::uint16_t>(pixels, step);
  std::size_t last = numbers.size() - 1;
  while (last > 0 && numbers[last] == 0) --last;
  const auto largest = static_cast<double>(last);
  const int range = range_of(largest, file_range);
  if (largest < kMinTop * range) return file_range - 1;

  const int width = range / kBins;
  const auto counts = binned(numbers, width);
  const int top = static_cast<int>(largest) / width;
  std::int64_t heap = 0, below = 0;
  int peak = top;
  for (int i = 0; i < kHeapBins; ++i) {
    const auto bin = static_cast<std::size_t>(top - i);
    heap += counts[bin];
    below += counts[bin - kHeapBins];
    if (counts[bin] > counts[static_cast<std::size_t>(peak)]) peak = top - i;
  }
  // A tail of a smooth histogram falls off; chance makes heaps of a few.
  constexpr std::int64_t kFew = 20;
  if (heap < kFew || heap < 4 * below) return file_range - 1;
  int low = peak;
  while (low > top - kHeapBins &&
         20 * counts[static_cast<std::size_t>(low - 1)] > counts[static_cast<std::size_t>(peak)])
    --low;
  return low * width;
}

}  // namespace strobe::digitize
