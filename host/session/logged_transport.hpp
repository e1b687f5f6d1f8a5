// A transport whose messages are kept in a session's log: those received that the loop acts on, and those
// published as they are published; with their seals, so that a replay can verify them too. What strangers send
// fills no disk. Times in the log are those of the start, gone on by CLOCK_MONOTONIC: setting the wall clock does not
// make a replay wait, or believe that the firmware was silent. Writes files; single-threaded.
#pragma once

#include <string>

#include "host/clock/machine_clock.hpp"
#include "host/messages/transport.hpp"
#include "host/session/session_folder.hpp"

namespace strobe::host {

class LoggedTransport final : public Transport {
 public:
  /// All references must outlive the object.
  LoggedTransport(Transport& transport, SessionFolder& folder, Clock& clock)
      : transport_(transport), folder_(folder), clock_(clock), started_(clock.read()) {}

  bool receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
               const Receiver& receiver) override;
  std::string sender() const override { return transport_.sender(); }
  void publish(const std::string& channel, Bytes bytes) override;
  void keep(const std::string& channel, Bytes bytes) override { log(channel, bytes); }

 private:
  void log(const std::string& channel, Bytes bytes);

  Transport& transport_;
  SessionFolder& folder_;
  Clock& clock_;
  HostReading started_;
};

}  // namespace strobe::host
