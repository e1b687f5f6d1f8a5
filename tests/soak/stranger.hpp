// A stranger on the lab's network, without the lab's key: he hears every packet to the host and sends it again,
// altered, cut, with made-up contents, under another lab's seal, on another channel, or later. And one who plays a
// log of yesterday back: packets that are sealed with the lab's key, of a firmware that runs no more. One thread's;
// allocates.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "tests/soak/bus.hpp"
#include "tests/support/sealed_sender.hpp"

namespace strobe::soak {

class Stranger {
 public:
  struct Packet {
    std::string channel;
    std::vector<std::uint8_t> bytes;
  };

  Stranger(std::uint64_t seed, std::string rig, const authentication::Key& lab_key);

  /// What he makes of a packet that he hears.
  Packet forge(const std::string& channel, std::span<const std::uint8_t> packet);
  /// Much the same as it was yesterday: of that day's firmware and host; each shot was aborted.
  Packet of_yesterday(const std::string& channel, std::span<const std::uint8_t> packet);

  /// The firmware of yesterday.
  std::int64_t old_boot() const { return old_boot_; }
  Random& random() { return random_; }

 private:
  Random random_;
  std::string rig_;
  std::int64_t old_boot_, old_host_;
  testing::SealedSender other_lab_, yesterday_;
  std::deque<Packet> heard_;
};

}  // namespace strobe::soak
