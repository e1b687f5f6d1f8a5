#include "sim/gev/stream_packets.hpp"

#include <algorithm>

namespace strobe::sim::gev {
namespace {

enum Content : std::uint32_t { kLeader = 1, kTrailer = 2, kPayload = 3 };
constexpr std::uint16_t kImagePayload = 1;
constexpr std::uint16_t kUnavailable = 0x800c;
constexpr std::uint32_t kIds = 0xffffff;

Packet header(std::uint16_t status, std::uint16_t block, Content content, std::uint32_t id) {
  Packet packet;
  append(packet, 2, status);
  append(packet, 2, block);
  append(packet, 4, (content << 24) | (id & kIds));
  return packet;
}

Packet leader(const StreamFrame& frame) {
  Packet packet = header(0, frame.block, kLeader, 0);
  append(packet, 4, kImagePayload);
  append(packet, 8, frame.timestamp);
  append(packet, 4, static_cast<std::uint32_t>(frame.pixel_format));
  append(packet, 4, frame.width);
  append(packet, 4, frame.height);
  append(packet, 8, 0);  // offsets
  append(packet, 4, 0);  // padding
  return packet;
}

Packet trailer(const StreamFrame& frame, std::uint32_t id) {
  Packet packet = header(0, frame.block, kTrailer, id);
  append(packet, 4, kImagePayload);
  append(packet, 4, frame.height);
  return packet;
}

std::size_t payload_size(const StreamFrame& frame) { return frame.packet_size - kStreamOverhead; }

}  // namespace

std::uint32_t packet_count(const StreamFrame& frame) {
  const std::size_t each = payload_size(frame);
  return static_cast<std::uint32_t>((frame.pixels.size() + each - 1) / each) + 2;
}

Packet stream_packet(const StreamFrame& frame, std::uint32_t id) {
  if (id == 0) return leader(frame);
  if (id == packet_count(frame) - 1) return trailer(frame, id);
  Packet packet = header(0, frame.block, kPayload, id);
  const std::size_t begin = std::min(frame.pixels.size(), (id - 1) * payload_size(frame));
  const std::size_t end = std::min(frame.pixels.size(), begin + payload_size(frame));
  packet.insert(packet.end(), frame.pixels.begin() + static_cast<std::ptrdiff_t>(begin),
                frame.pixels.begin() + static_cast<std::ptrdiff_t>(end));
  if (id >= packet_count(frame)) packet.resize(packet.size() + payload_size(frame));
  return packet;
}

Packet unavailable_packet(std::uint16_t block, std::uint32_t id) {
  return header(kUnavailable, block, kPayload, id);
}

}  // namespace strobe::sim::gev
