// LCM URLs of UDP multicast, the only ones that the programs take. What is not read here to its last
// character is refused: liblcm's own reader crashes on some (no port) and takes ports such as 0x1df3 or "
// 7667", and any other kind of URL would bring in liblcm's receiver, which is not safe for untrusted bytes
// (lcm_datagram.hpp). The environment's LCM_DEFAULT_URL is never read. Pure; thread-safe.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace strobe::wire {

struct MulticastGroup {
  std::string address;           ///< IPv4, dotted, 224.0.0.0 to 239.255.255.255
  std::uint16_t port = 0;        ///< 1 to 65535
  int receive_buffer_bytes = 0;  ///< 0: as the system has it

  friend bool operator==(const MulticastGroup&, const MulticastGroup&) = default;
};

struct LcmUrl {
  MulticastGroup group;
  int ttl = 0;  ///< 0 to 255; 0: this machine only

  friend bool operator==(const LcmUrl&, const LcmUrl&) = default;
};

inline constexpr int kMaxReceiveBuffer_bytes = 1 << 30;

/// Reads udpm://ADDRESS:PORT?ttl=N&recv_buf_size=N. Both parameters may be left out, and ADDRESS:PORT, which
/// is then LCM's default group. Numbers are decimal, without signs, spaces or leading zeros. The error says
/// what is wrong, as one line.
Result<LcmUrl> read_lcm_url(std::string_view text);

/// As liblcm understands it in only one way; read_lcm_url reads the same from it.
std::string to_text(const LcmUrl& url);

/// What is wrong with a URL; empty if nothing is. Shaped as a check of a command-line option.
std::string lcm_url_problem(const std::string& text);

}  // namespace strobe::wire
