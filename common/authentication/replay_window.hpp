// Which numbered packets have come before: a sliding window for each sender, as in IPsec (RFC 4303, 3.4.3).
// Allocates once for each sender kept; one thread's.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>

#include "common/authentication/packet_seal.hpp"

namespace strobe::authentication {

/// Of one sender.
class ReplayWindow {
 public:
  /// A network may bring a packet after so many later ones: a resend's thousands pass in a tenth of a second.
  static constexpr std::int64_t kSize = 16'384;

  /// Returns true once for each number; false also for those that are kSize or more below the largest.
  /// Numbers below 1 are none.
  bool accept(std::int64_t sequence);

 private:
  std::bitset<kSize> seen_;  ///< of the numbers in (largest_ - kSize, largest_], by the remainder
  std::int64_t largest_ = 0;
};

/// Of all senders, which a lab has few of; only packets of the lab's key come here.
class ReplayWindows {
 public:
  /// The one idle for longest is forgotten when there are more: its packets could be repeated then, and are
  /// known by what they say.
  static constexpr std::size_t kMaxSenders = 64;

  bool accept(const PacketNumber& number);
  std::size_t senders() const { return senders_.size(); }

 private:
  struct Sender {
    ReplayWindow window;
    std::int64_t used = 0;
  };
  std::map<std::int64_t, std::unique_ptr<Sender>> senders_;
  std::int64_t packets_ = 0;
};

}  // namespace strobe::authentication
