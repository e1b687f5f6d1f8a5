// A cable between LCM on this side and an emulated machine: multicast datagrams of this machine's loopback
// interface go out as Ethernet frames through QEMU's datagram socket, and those that come back are sent here.
// A thread of its own; made and destroyed by one.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace strobe::kernel {

struct Multicast {
  std::string group;       ///< dotted address
  std::uint16_t port = 0;  ///< of source and destination
};

/// An Ethernet frame with that datagram from the tests' side of the cable.
std::vector<std::uint8_t> frame_of(const Multicast& to, std::span<const std::uint8_t> payload);

/// The payload of a frame if it is a whole UDP datagram for that group and port.
std::optional<std::span<const std::uint8_t>> payload_of(const Multicast& to,
                                                        std::span<const std::uint8_t> frame);

class LcmBridge {
 public:
  /// QEMU is to send to `ours` and to listen at `theirs`. std::runtime_error if a socket cannot be had.
  LcmBridge(Multicast multicast, const std::filesystem::path& ours, const std::filesystem::path& theirs);
  ~LcmBridge();
  LcmBridge(const LcmBridge&) = delete;
  LcmBridge& operator=(const LcmBridge&) = delete;

  int sent_in() const { return sent_in_; }    ///< datagrams handed to the emulated machine
  int sent_out() const { return sent_out_; }  ///< and from it

 private:
  void run();
  void from_machine();
  void from_here();

  Multicast multicast_;
  std::filesystem::path theirs_;
  int cable_ = -1, listener_ = -1, sender_ = -1;
  std::uint16_t sender_port_ = 0;
  std::vector<std::uint8_t> buffer_;
  std::atomic<int> sent_in_{0};
  std::atomic<int> sent_out_{0};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace strobe::kernel
