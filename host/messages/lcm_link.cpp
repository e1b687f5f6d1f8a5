#include "host/messages/lcm_link.hpp"

#include <poll.h>

#include <cerrno>
#include <vector>

#include "common/messages/channels.hpp"

namespace strobe::host {

LcmLink::LcmLink(const std::string& url, const std::string& rig, Receiver receiver)
    : lcm_(url),
      receiver_(std::move(receiver)),
      rig_channels_("STROBE/" + rig + "/"),
      command_channel_(messages::channel_name(rig, messages::Channel::command)),
      readout_channel_(messages::channel_name(rig, messages::Channel::readout)),
      frame_channel_(messages::channel_name(rig, messages::Channel::frame)) {}

Result<std::unique_ptr<LcmLink>> LcmLink::open(const std::string& url, const std::string& rig,
                                               Receiver receiver) {
  std::unique_ptr<LcmLink> link(new LcmLink(url, rig, std::move(receiver)));
  if (!link->lcm_.good()) {
    return fail("LCM cannot be opened on " + url +
                " (is there a route for multicast? ip route add 224.0.0.0/4 dev lo)");
  }
  if (auto listening = link->listen(url, rig); !listening) return tl::unexpected(listening.error());
  return link;
}

Result<void> LcmLink::listen(const std::string& url, const std::string& rig) {
  if (const auto group = wire::multicast_group(url)) {
    auto socket = wire::ChannelSocket::open(*group, {rig_channels_, false, command_channel_});
    if (!socket) return tl::unexpected(socket.error());
    socket_.emplace(std::move(*socket));
    return {};
  }
  // A rig's name has no character that means something in a regular expression.
  auto* subscription = lcm_.subscribe("STROBE/" + rig + "/.*", &LcmLink::handle, this);
  subscription->setQueueCapacity(messages::kSubscriptionQueueCapacity);
  return {};
}

void LcmLink::handle(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  if (channel != command_channel_) receiver_(channel, buffer->data, buffer->data_size);
}

bool LcmLink::take_datagram() {
  const auto received = socket_->receive();
  if (!received) return false;
  const auto message = assembler_.take(received->sender, received->bytes);
  if (!message || !message->channel.starts_with(rig_channels_) || message->channel == command_channel_)
    return true;
  receiver_(std::string(message->channel), message->data.data(), message->data.size());
  return true;
}

bool LcmLink::wait(int milliseconds, std::span<const int> others) {
  std::vector<pollfd> wanted{{socket_ ? socket_->fd() : lcm_.getFileno(), POLLIN, 0}};
  for (const int other : others) wanted.push_back({other, POLLIN, 0});
  if (poll(wanted.data(), wanted.size(), milliseconds) < 0 && errno != EINTR) return false;
  if (wanted[0].revents == 0) return true;
  if (socket_) {
    take_datagram();
    return true;
  }
  errno = 0;
  return lcm_.handleTimeout(0) >= 0 || errno == EINTR;
}

bool LcmLink::drain() {
  for (int i = 0; i < messages::kSubscriptionQueueCapacity; ++i) {
    if (socket_) {
      if (!take_datagram()) return true;
      continue;
    }
    errno = 0;
    const int handled = lcm_.handleTimeout(0);
    if (handled < 0 && errno != EINTR) return false;
    if (handled <= 0) return true;
  }
  return true;
}

void LcmLink::publish_command(std::span<const std::uint8_t> sealed) {
  lcm_.publish(command_channel_, sealed.data(), static_cast<unsigned>(sealed.size()));
}
void LcmLink::publish(const strobe_msgs::readout_t& readout) { lcm_.publish(readout_channel_, &readout); }
void LcmLink::publish(const strobe_msgs::frame_t& frame) { lcm_.publish(frame_channel_, &frame); }

}  // namespace strobe::host
