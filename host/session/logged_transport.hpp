// A transport whose messages are kept in a session's log: those received, and those published as they are
// published. What this host has published comes back by multicast; it is neither logged nor handed on again.
// Writes files; single-threaded.
#pragma once

#include <string>

#include "host/clock/clock_reading.hpp"
#include "host/messages/transport.hpp"
#include "host/session/session_folder.hpp"

namespace strobe::host {

class LoggedTransport final : public Transport {
 public:
  /// host_id: of this host. All references must outlive the object.
  LoggedTransport(Transport& transport, SessionFolder& folder, Clock& clock, const std::string& rig,
                  std::int64_t host_id);

  bool receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
               const Receiver& receiver) override;
  void publish(const std::string& channel, Bytes bytes) override;

 private:
  bool published_here(const std::string& channel, Bytes bytes) const;
  void log(const std::string& channel, Bytes bytes);

  Transport& transport_;
  SessionFolder& folder_;
  Clock& clock_;
  std::string frame_channel_, readout_channel_;
  std::int64_t host_id_;
};

}  // namespace strobe::host
