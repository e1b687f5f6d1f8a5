// Any bytes as a frame: an error or a frame, which every estimator takes or refuses, and which reads back as
// written.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "common/messages/json_conversions.hpp"
#include "common/reduction/reduce.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe;
  using namespace strobe::reduction;
  const auto frame = messages::frame_from_json(std::string_view(reinterpret_cast<const char*>(data), size));
  if (!frame) return 0;
  const std::string text = messages::frame_to_json(*frame);
  const auto again = messages::frame_from_json(text);
  if (!again || messages::frame_to_json(*again) != text) std::abort();
  for (const Estimator estimator : {Estimator::best, Estimator::two_point, Estimator::legacy}) {
    const auto readout = reduce(*frame, estimator, {.likely_cause = true});
    if (readout) (void)messages::readout_to_json(*readout);
  }
  return 0;
}
