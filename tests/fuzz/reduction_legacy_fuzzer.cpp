// Any bytes as a file of the thesis's format: errors or frames, and every frame can be reduced.
#include <cstdint>
#include <string_view>

#include "common/reduction/legacy_file.hpp"
#include "common/reduction/reduce.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::reduction;
  const std::string_view text = text_of(data, size);
  for (const auto& legacy : parse_legacy(text, "file")) {
    if (!legacy) continue;
    (void)reduce_legacy(*legacy);
    for (const Estimator estimator : {Estimator::best, Estimator::two_point, Estimator::legacy})
      (void)reduce(frame_from_legacy(*legacy), estimator);
  }
  return 0;
}
