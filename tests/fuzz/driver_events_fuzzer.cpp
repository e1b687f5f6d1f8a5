// What a camera's driver says, moved by whatever a camera sends it: any line is either an event, which comes back the same
// from the line that it is written as, or an error of one line. Requests likewise.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "host/tether/driver_messages.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

namespace {

void check_message(std::string_view line, const auto& parse) {
  const auto message = parse(line);
  if (!message) return require_one_line(message.error().message, "");
  const std::string written = strobe::tether::to_line(*message);
  require(written.find('\n') == written.npos);
  const auto again = parse(written);
  require(again && strobe::tether::to_line(*again) == written);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view line = text_of(data, size);
  check_message(line, strobe::tether::parse_event);
  check_message(line, strobe::tether::parse_request);
  return 0;
}
