// Datagrams come from anybody: any sequence of them yields whole messages within bounds, or nothing. Input:
// records of a sender, two bytes of size, and a datagram.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "common/wire/assembler.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::wire;
  Assembler assembler;
  unsigned sum = 0;
  for (std::span<const std::uint8_t> left(data, size); left.size() >= 3;) {
    const std::uint64_t sender = left[0] % 3;
    const std::size_t wanted = std::size_t{left[1]} << 8 | left[2];
    left = left.subspan(3);
    const auto datagram = left.first(std::min(wanted, left.size()));
    left = left.subspan(datagram.size());
    const auto message = assembler.take(sender, datagram);
    if (!message) continue;
    if (message->channel.size() > kLongestChannel || message->data.size() > Assembler::kMaxMessage_bytes)
      std::abort();
    for (const char letter : message->channel) sum += static_cast<unsigned char>(letter);
    for (const std::uint8_t byte : message->data) sum += byte;  // every byte can be read
  }
  const volatile unsigned read_all = sum;
  (void)read_all;
  return 0;
}
