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
  folder_.log(channel, bytes.data(), bytes.size(), clock_.read().wall);
}

}  // namespace strobe::host
