// Receives the datagrams of some LCM channels through a UDP socket of its own. A packet filter in the kernel
// drops all others, so that neither the program's own messages on other channels, which multicast returns,
// nor a flood there wakes the reader. It calls the system, as firmware and host must treat untrusted bytes
// alike. One thread's once open; allocates at the start, and where interfaces vanish.
//
// The kernel joins a group on the interface that the route names at that moment. An interface made anew (USB,
// a VPN, a bridge) is another one: what is sent still goes there, nothing comes. stay_joined() joins it
// there, too.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/wire/lcm_datagram.hpp"
#include "common/wire/lcm_url.hpp"
#include "common/wire/link_changes.hpp"

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

  /// May be another one after stay_joined().
  int fd() const { return fd_; }

  /// To be called again and again. Joins the group where it now is to be joined: at once when an interface,
  /// an address or a route has changed, else every kJoinAgain, in case that was not told. What is joined is
  /// not left for it, so that nothing is lost and no switch learns of it.
  void stay_joined();
  static constexpr int kJoinAgain_s = 2;

  struct Received {
    std::uint64_t sender = 0;  ///< its address and port: address_of()
    /// Valid until the next call; empty if the network reported an error.
    std::span<const std::uint8_t> bytes;
  };
  /// The next datagram; nullopt if none is waiting. May be of another channel where the kernel has no
  /// filters.
  std::optional<Received> receive();

 private:
  ChannelSocket(MulticastGroup group, ChannelChoice choice);
  bool join();
  void leave(int interface);
  bool due() const;
  void replace();

  MulticastGroup group_;
  ChannelChoice choice_;
  int fd_ = -1;
  int timer_ = -1;
  LinkChanges links_;
  std::vector<std::uint8_t> buffer_;
};

/// "192.168.0.5"; empty for 0, nobody's.
std::string address_of(std::uint64_t sender);

}  // namespace strobe::wire
