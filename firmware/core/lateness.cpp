#include "firmware/core/lateness.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace strobe::firmware {

std::size_t LatenessHistogram::bin_of(std::int64_t ns) noexcept {
  const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(ns, 0));
  const int octave = std::max(0, static_cast<int>(std::bit_width(value)) - kStepBits - 1);
  const std::size_t bin =
      (static_cast<std::size_t>(octave) << kStepBits) + static_cast<std::size_t>(value >> octave);
  return std::min(bin, kBins - 1);
}

std::int64_t LatenessHistogram::last_of(std::size_t bin) noexcept {
  const std::size_t first_octave = std::size_t{2} << kStepBits;
  if (bin < first_octave) return static_cast<std::int64_t>(bin);
  const std::size_t octave = (bin >> kStepBits) - 1;
  const std::size_t step = bin - (octave << kStepBits);
  return static_cast<std::int64_t>(((step + 1) << octave) - 1);
}

void LatenessHistogram::add(Duration lateness) noexcept {
  ++bins_[bin_of(lateness.ns)];
  ++count_;
  max_ = std::max(max_, lateness);
}

Duration LatenessHistogram::percentile(double share) const noexcept {
  const auto wanted = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(count_)));
  std::int64_t seen = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (seen > 0 && seen >= wanted) return std::min(nanoseconds(last_of(bin)), max_);
  }
  return max_;
}

}  // namespace strobe::firmware
