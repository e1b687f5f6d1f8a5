// Telemetry comes from the network: any bytes are not the lab's unless sealed, whatever channel they are on; a
// sealed packet is opened to the same message once, and no part of it more is taken for the message.
// Input: a byte of the channel's size, the channel, the packet.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "common/authentication/packet_seal.hpp"
#include "common/authentication/replay_window.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe;
using namespace strobe::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const authentication::Key key = authentication::Key::random();
  static const authentication::PacketSeal seal(key);
  if (size == 0) return 0;
  const std::size_t channel_size = std::min<std::size_t>(data[0], size - 1);
  const std::string_view channel(reinterpret_cast<const char*>(data) + 1, channel_size);
  const std::span<const std::uint8_t> bytes(data + 1 + channel_size, size - 1 - channel_size);
  require(!seal.open(channel, bytes));  // no chance to guess the key
  require(authentication::message_of(bytes).size() <= bytes.size());

  authentication::PacketNumber number{static_cast<std::int64_t>(size), data[0]};
  std::vector<std::uint8_t> packet = seal.seal(channel, bytes, number);
  const auto opened = seal.open(channel, packet);
  require(opened && std::ranges::equal(opened->message, bytes));
  require(opened->number.sender == number.sender && opened->number.sequence == number.sequence);
  require(std::ranges::equal(authentication::message_of(packet), bytes));
  authentication::ReplayWindows windows;
  require(windows.accept(opened->number) == (number.sequence >= 1));
  require(!windows.accept(opened->number));

  packet[size % packet.size()] ^= static_cast<std::uint8_t>(data[0] | 1);
  require(!seal.open(channel, packet));
  return 0;
}
