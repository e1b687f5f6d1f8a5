// Photographs come from cameras, copies and half-finished writes: any bytes are either a photograph within
// its limits, in which the search for the ball ends, or an error of one line.
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

#include "host/digitize/candidates/candidates.hpp"
#include "host/digitize/image/photograph.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::digitize;
  // Large pictures are for a test: here they only cost rounds.
  constexpr std::int64_t kMaxSearched = 100'000;
  const auto photograph = decode_photograph({data, size}, "fuzz.tif");
  if (!photograph) return require_one_line(photograph.error().message, "fuzz.tif: "), 0;
  require(photograph->width() >= 16 && photograph->height() >= 16);
  require(photograph->bits == 1 || (photograph->bits >= 8 && photograph->bits <= 16));
  require(photograph->saturation > 0.0F && photograph->saturation <= 1.0F);
  require(photograph->intensity.type() == CV_32FC1);
  require(cv::checkRange(photograph->intensity, true, nullptr, 0.0, 1.0001));
  if (std::int64_t{photograph->width()} * photograph->height() > kMaxSearched) return 0;
  for (const auto& candidate : find_candidates(*photograph, {6.0, 9.0}, Effort::fast)) {
    require(candidate.radius_image_px >= 6.0 && candidate.radius_image_px <= 9.0);
    require(candidate.score >= 0.0 && candidate.score <= 1.0);
  }
  return 0;
}
