// LCM's UDP multicast protocol: the datagrams. LCM's own receiver is not safe for untrusted
// bytes: in version 1.3.1 lcm_udpm.c, _recv_message_fragment(), holds "fragment_offset + frag_size >
// fbuf->data_size" in 32 bits against the buffer, then copies to fbuf->data + fragment_offset: a part of 32
// bytes at offset 0xfffffff0 passes and is written outside, which ends lcm-logger with SIGSEGV; the size in a
// first part, up to 256 MB, is allocated on its word alone. Pure; thread-safe. Wire format: LCM's
// documentation, "UDP Multicast Protocol Description".
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace strobe::wire {

/// A message's datagram, or one of several. Views into the datagram.
struct Datagram {
  std::string_view channel;            ///< at most 63 characters; empty in all parts but the first
  std::span<const std::uint8_t> data;  ///< of the message, or of this part
  std::uint32_t number = 0;            ///< the message's, rising with each sender
  std::uint32_t message_bytes = 0;     ///< of the whole message
  std::uint32_t at = 0;                ///< where the part's data goes
  std::uint16_t part = 0;
  std::uint16_t parts = 1;  ///< 1: the message is whole
};

/// Returns nullopt if it is not LCM's. Valid: any bytes. A part's data always lies within its message.
std::optional<Datagram> read_datagram(std::span<const std::uint8_t> bytes);

/// A UDP datagram's data at most.
inline constexpr std::size_t kLargestDatagram_bytes = 65'507;

// The layout, for the kernel's filter as well; numbers are big-endian.
inline constexpr std::uint32_t kWholeMark = 0x4c433032;  ///< "LC02", then the number, then the channel
/// "LC03", number, message's size, place, part, parts.
inline constexpr std::uint32_t kPartMark = 0x4c433033;
inline constexpr std::size_t kWholeHeader_bytes = 8;
inline constexpr std::size_t kPartHeader_bytes = 20;
inline constexpr std::size_t kPartAt = 16;
inline constexpr std::size_t kLongestChannel = 63;

}  // namespace strobe::wire
