// Publishes over LCM. Commands are received elsewhere (command_feed.hpp).
#pragma once

#include <lcm/lcm-cpp.hpp>

#include "common/authentication/packet_seal.hpp"
#include "firmware/ports/message_bus.hpp"

namespace strobe::firmware {

class LcmBus final : public MessageBus {
 public:
  explicit LcmBus(lcm::LCM& lcm) : lcm_(lcm) {}

  void publish(const std::string& channel, std::span<const std::uint8_t> bytes) override;

 private:
  lcm::LCM& lcm_;
};

/// A bus whose packets are sealed with the lab's key (common/authentication/packet_seal.hpp): what a resend
/// takes from the journal is sent under a number of its own, as no packet is good twice. One thread's: the
/// publisher's.
class SealedBus final : public MessageBus {
 public:
  /// `bus` must outlive it.
  SealedBus(MessageBus& bus, const authentication::Key& key, std::int64_t boot_id)
      : bus_(bus), seal_(key), newest_{boot_id, 0} {}

  void publish(const std::string& channel, std::span<const std::uint8_t> bytes) override {
    ++newest_.sequence;
    bus_.publish(channel, seal_.seal(channel, bytes, newest_));
  }

 private:
  MessageBus& bus_;
  authentication::PacketSeal seal_;
  authentication::PacketNumber newest_;
};

}  // namespace strobe::firmware
