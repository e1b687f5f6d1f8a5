// Packets of the stream channel (GVSP, GigE Vision 1.2, sections 22 to 27): a frame as leader, payload and
// trailer. Pure; thread-safe; allocates.
#pragma once

#include "sim/gev/bytes.hpp"
#include "sim/gev/description.hpp"

namespace strobe::sim::gev {

/// Headers of IP, UDP and GVSP, which the packet size of the stream channel counts.
inline constexpr std::uint32_t kStreamOverhead = 36;

struct StreamFrame {
  std::uint16_t block = 1;      ///< 1 to 65535, then 1 again
  std::uint64_t timestamp = 0;  ///< of the camera's clock: when the exposure began [ticks]
  PixelFormat pixel_format = PixelFormat::mono8;
  std::uint32_t width = 0, height = 0;  ///< as the leader says; px
  std::uint32_t packet_size = 1500;     ///< bytes, with all headers; over kStreamOverhead
  Packet pixels;                        ///< rows from the top, numbers of 16 bits low byte first
};

/// Leader, payload packets and trailer.
std::uint32_t packet_count(const StreamFrame& frame);

/// By its id: 0 is the leader, packet_count() - 1 the trailer. Beyond: payload of zeros.
Packet stream_packet(const StreamFrame& frame, std::uint32_t id);

/// In place of one that is not there any more.
Packet unavailable_packet(std::uint16_t block, std::uint32_t id);

}  // namespace strobe::sim::gev
