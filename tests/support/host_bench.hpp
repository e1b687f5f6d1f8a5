// What a host of a test runs on: a clock that the test moves, and a bus that brings what the test says and
// remembers what was sent.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/messages/channels.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/messages/transport.hpp"

namespace strobe::testing {

struct ManualClock final : host::Clock {
  Duration now = std::chrono::seconds{100};
  Duration wall_ahead{};
  Duration asleep{};  ///< how long this machine has been suspended
  host::HostReading read() override { return {HostTime{now}, WallTime{now + wall_ahead}, now + asleep}; }
};

struct RememberingBus final : host::Transport {
  using Packet = std::pair<std::string, std::vector<std::uint8_t>>;  ///< its channel first

  std::vector<Packet> arriving;  ///< given to the next receive(), once
  std::vector<Packet> sent;
  bool failed = false;

  bool receive(std::chrono::milliseconds, std::span<const int>, const Receiver& receiver) override {
    for (const auto& [name, bytes] : std::exchange(arriving, {})) receiver(name, bytes);
    return !failed;
  }
  void publish(const std::string& name, Bytes bytes) override {
    sent.emplace_back(name, std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
  }
  std::vector<std::vector<std::uint8_t>> sent_on(const std::string& channel) const {
    std::vector<std::vector<std::uint8_t>> packets;
    for (const auto& [name, bytes] : sent)
      if (name == channel) packets.push_back(bytes);
    return packets;
  }
};

}  // namespace strobe::testing
