// Receives the datagrams of some LCM channels through a UDP socket of its own. A packet filter in the kernel
// drops all others, so that neither the program's own messages on other channels, which multicast returns,
// nor a flood there wakes the reader. It calls the system, as firmware and host must treat untrusted bytes
// alike. One thread's once open; allocates at the start only.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/wire/lcm_datagram.hpp"
#include "common/wire/lcm_url.hpp"

namespace strobe::wire {

struct ChannelChoice {
  std::string wanted;    ///< a channel, or the beginning of channels
  bool whole = true;     ///< `wanted` is a whole channel; of messages of several parts the first part comes
  std::string unwanted;  ///< one channel that is not wanted; empty: none
};

class ChannelSocket {
 public:
  /// Fails if the group cannot be joined.
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
  /// The next datagram; nullopt if none is waiting. May be of another channel where the kernel has no
  /// filters.
  std::optional<Received> receive();

 private:
  explicit ChannelSocket(int fd) : fd_(fd), buffer_(kLargestDatagram_bytes) {}

  int fd_;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace strobe::wire
