// One of the lab, to tests: makes messages into packets as firmware, hosts and tablet send them, each under a
// number of its own. One thread's.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/authentication/packet_seal.hpp"
#include "common/messages/well_formed.hpp"

namespace strobe::testing {

class SealedSender {
 public:
  explicit SealedSender(const authentication::Key& key, std::int64_t sender = 500)
      : seal_(key), newest_{sender, 0} {}

  std::vector<std::uint8_t> packet(std::string_view channel, authentication::Bytes message) {
    ++newest_.sequence;
    return seal_.seal(channel, message, newest_);
  }
  template <typename Message>
  requires requires(const Message& message) { message.getEncodedSize(); }
  std::vector<std::uint8_t> packet(std::string_view channel, const Message& message) {
    return packet(channel, authentication::Bytes(messages::encode(message)));
  }

 private:
  authentication::PacketSeal seal_;
  authentication::PacketNumber newest_;
};

}  // namespace strobe::testing
