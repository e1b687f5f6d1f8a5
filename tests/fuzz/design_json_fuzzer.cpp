// Designs that a session was fired with come as files: any bytes are either a promise within its limits, or an error of
// one line that names the file.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "host/design/promise.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::host;
  const auto promise = parse_promise(text_of(data, size), "fuzz.json");
  if (!promise) return require_one_line(promise.error().message, "fuzz.json"), 0;
  for (const auto& quantity : *promise)
    require(!quantity || (quantity->shared_sd >= 0.0 && quantity->shared_sd <= quantity->shot_sd));
  return 0;
}
