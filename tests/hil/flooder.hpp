// A stranger on the bus who sends as fast as the machine can: packets that look like commands, sealed with
// another key; replays of true ones; bytes without sense; datagrams of the largest size. A thread of its own.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace strobe::hil {

using Bytes = std::vector<std::uint8_t>;

/// A socket that sends datagrams to an LCM URL's group, on this machine only. std::runtime_error if there is
/// none.
class RawSender {
 public:
  explicit RawSender(const std::string& lcm_url);
  ~RawSender();
  RawSender(const RawSender&) = delete;
  RawSender& operator=(const RawSender&) = delete;

  bool send(const Bytes& datagram) const;  ///< false: the kernel has no room
  /// As LCM would send it, in one datagram.
  static Bytes whole(std::string_view channel, const Bytes& message);

 private:
  int fd_ = -1;
};

class Flooder {
 public:
  enum Kind { forged, replayed, garbage, oversized };
  static constexpr std::size_t kKinds = 4;

  /// true_command: sealed bytes that the firmware has executed before.
  Flooder(const std::string& lcm_url, const std::string& rig, const Bytes& true_command);
  ~Flooder() { stop(); }

  std::int64_t stop();  ///< packets sent
  std::int64_t sent() const { return sent_; }

 private:
  void run(const std::stop_token& stop);

  RawSender sender_;
  std::array<Bytes, kKinds> datagrams_;
  std::atomic<std::int64_t> sent_{0};
  std::jthread thread_;
};

}  // namespace strobe::hil
