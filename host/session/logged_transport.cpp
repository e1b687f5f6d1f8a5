#include "host/session/logged_transport.hpp"

namespace strobe::host {

bool LoggedTransport::receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
                              const Receiver& receiver) {
  return transport_.receive(max_wait, descriptors, receiver);
}

void LoggedTransport::publish(const std::string& channel, Bytes bytes) {
  log(channel, bytes);
  transport_.publish(channel, bytes);
}

void LoggedTransport::log(const std::string& channel, Bytes bytes) {
  folder_.log(channel, bytes, started_.wall + (clock_.read().mono - started_.mono));
}

}  // namespace strobe::host
