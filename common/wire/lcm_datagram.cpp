#include "common/wire/lcm_datagram.hpp"

#include <algorithm>

namespace strobe::wire {

namespace {

std::uint32_t number_at(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (const std::uint8_t byte : bytes.subspan(at, size)) value = value << 8 | byte;
  return value;
}

/// Moves the channel and the zero that ends it out of the datagram's data; false: there is none.
bool take_channel(Datagram& datagram) {
  const auto& data = datagram.data;
  const auto window = data.first(std::min(data.size(), kLongestChannel + 1));
  const auto end = std::find(window.begin(), window.end(), std::uint8_t{0});
  const auto length = static_cast<std::size_t>(end - window.begin());
  if (end == window.end() || length == 0) return false;
  datagram.channel = {reinterpret_cast<const char*>(data.data()), length};
  datagram.data = data.subspan(length + 1);
  return true;
}

std::optional<Datagram> read_whole(std::span<const std::uint8_t> bytes) {
  Datagram datagram;
  datagram.number = number_at(bytes, 4, 4);
  datagram.data = bytes.subspan(kWholeHeader_bytes);
  if (!take_channel(datagram)) return std::nullopt;
  datagram.message_bytes = static_cast<std::uint32_t>(datagram.data.size());
  return datagram;
}

std::optional<Datagram> read_part(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kPartHeader_bytes) return std::nullopt;
  Datagram datagram;
  datagram.number = number_at(bytes, 4, 4);
  datagram.message_bytes = number_at(bytes, 8, 4);
  datagram.at = number_at(bytes, 12, 4);
  datagram.part = static_cast<std::uint16_t>(number_at(bytes, kPartAt, 2));
  datagram.parts = static_cast<std::uint16_t>(number_at(bytes, kPartAt + 2, 2));
  datagram.data = bytes.subspan(kPartHeader_bytes);
  if (datagram.part >= datagram.parts) return std::nullopt;
  if (datagram.part == 0 && !take_channel(datagram)) return std::nullopt;
  const bool within =
      datagram.at <= datagram.message_bytes && datagram.data.size() <= datagram.message_bytes - datagram.at;
  return within ? std::optional(datagram) : std::nullopt;
}

}  // namespace

std::optional<Datagram> read_datagram(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kWholeHeader_bytes) return std::nullopt;
  const std::uint32_t mark = number_at(bytes, 0, 4);
  if (mark == kWholeMark) return read_whole(bytes);
  return mark == kPartMark ? read_part(bytes) : std::nullopt;
}

}  // namespace strobe::wire
