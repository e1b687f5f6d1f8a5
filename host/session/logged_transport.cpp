#include "host/session/logged_transport.hpp"

#include <strobe_msgs/frame_t.hpp>

#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"

namespace strobe::host {

LoggedTransport::LoggedTransport(Transport& transport, SessionFolder& folder, Clock& clock,
                                 const std::string& rig, std::int64_t host_id)
    : transport_(transport),
      folder_(folder),
      clock_(clock),
      frame_channel_(messages::channel_name(rig, messages::Channel::frame)),
      readout_channel_(messages::channel_name(rig, messages::Channel::readout)),
      host_id_(host_id) {}

bool LoggedTransport::published_here(const std::string& channel, Bytes bytes) const {
  if (channel == readout_channel_) return messages::readout_host(bytes.data(), bytes.size()) == host_id_;
  if (channel != frame_channel_) return false;
  strobe_msgs::frame_t frame;
  return messages::decode_checked(frame, bytes.data(), bytes.size()) &&
         frame.host_id == host_id_;
}

bool LoggedTransport::receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
                              const Receiver& receiver) {
  return transport_.receive(max_wait, descriptors, [&](const std::string& channel, Bytes bytes) {
    if (published_here(channel, bytes)) return;
    log(channel, bytes);  // first, so that the log holds what a result came from
    receiver(channel, bytes);
  });
}

void LoggedTransport::publish(const std::string& channel, Bytes bytes) {
  log(channel, bytes);
  transport_.publish(channel, bytes);
}

void LoggedTransport::log(const std::string& channel, Bytes bytes) {
  folder_.log(channel, bytes.data(), bytes.size(), clock_.read().wall);
}

}  // namespace strobe::host
