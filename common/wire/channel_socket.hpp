// The datagrams of some LCM channels, from a UDP socket of its own. A program in the kernel lets no others
// through: neither one's own messages on other channels, which multicast brings back, nor a flood of a
// stranger's there ever wakes the reader. With key_file.cpp the only part of common/ that calls the system:
// firmware and host must meet strangers' bytes in the same way. One thread's, after it was opened; allocates
// at the start only.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/wire/lcm_datagram.hpp"

namespace strobe::wire {

struct ChannelChoice {
  std::string wanted;    ///< a channel, or what channels begin with
  bool whole = true;     ///< `wanted` is a whole channel; of messages of several parts the first part comes
  std::string unwanted;  ///< one channel that is not wanted; empty: none
};

class ChannelSocket {
 public:
  /// Fails where the group cannot be joined.
  static Result<ChannelSocket> open(const MulticastGroup& group, const ChannelChoice& choice);

  ChannelSocket(ChannelSocket&& other) noexcept;
  ChannelSocket& operator=(ChannelSocket&&) = delete;
  ~ChannelSocket();

  int fd() const { return fd_; }

  struct Received {
    std::uint64_t sender = 0;  ///< its address and port
    /// Valid until the next call; empty if the network reported an error.
    std::span<const std::uint8_t> bytes;
  };
  /// The next datagram; nothing: none is waiting. May be of another channel where the kernel has no filters.
  std::optional<Received> receive();

 private:
  explicit ChannelSocket(int fd) : fd_(fd), buffer_(kLargestDatagram_bytes) {}

  int fd_;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace strobe::wire
