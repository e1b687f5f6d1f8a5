// The port through which a host's messages come and go: LCM in the programs, a virtual bus in the soak test.
// Single-threaded.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace strobe::host {

class Transport {
 public:
  using Bytes = std::span<const std::uint8_t>;
  /// Called with each message: its channel and its bytes as they came. Must not throw.
  using Receiver = std::function<void(const std::string& channel, Bytes)>;

  virtual ~Transport() = default;

  /// Waits until a message is there or one of the descriptors is readable, at most max_wait, then hands over
  /// what has arrived. Returns false if nothing can be received any more.
  virtual bool receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
                       const Receiver& receiver) = 0;
  /// Who sent the message that is being handed over: an IP address; empty where there is none.
  virtual std::string sender() const { return ""; }
  virtual void publish(const std::string& channel, Bytes bytes) = 0;
  /// Called with each message handed over that will be acted on, before it is.
  virtual void keep(const std::string& /*channel*/, Bytes) {}
};

/// Nothing comes and nothing goes: messages are handed over by other ways.
class NullTransport final : public Transport {
 public:
  bool receive(std::chrono::milliseconds, std::span<const int>, const Receiver&) override { return false; }
  void publish(const std::string&, Bytes) override {}
};

}  // namespace strobe::host
