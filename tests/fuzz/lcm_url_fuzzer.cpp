// LCM URLs come from options and rig files: whatever is taken reads the same from its own text, is a multicast
// group that the system accepts, and leaves liblcm nothing to understand otherwise.
#include <arpa/inet.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/wire/lcm_url.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::wire;
  using strobe::fuzz::require;
  const std::string text(strobe::fuzz::text_of(data, size));
  const auto url = read_lcm_url(text);
  if (!url) {
    strobe::fuzz::require_one_line(url.error().message, "\"");
    require(url.error().message.size() < 300);
    return 0;
  }
  const std::string plain = to_text(*url);
  const auto again = read_lcm_url(plain);
  require(again && *again == *url && to_text(*again) == plain);
  require(plain.find_first_not_of("udpm:/0123456789.?tl=&recv_bufsiz") == plain.npos);
  in_addr address{};
  require(inet_pton(AF_INET, url->group.address.c_str(), &address) == 1 &&
          IN_MULTICAST(ntohl(address.s_addr)));
  require(url->group.port > 0 && url->ttl >= 0 && url->ttl <= 255 && url->group.receive_buffer_bytes >= 0);
  return 0;
}
