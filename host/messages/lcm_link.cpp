#include "host/messages/lcm_link.hpp"

#include <poll.h>

#include <cerrno>
#include <vector>

#include "common/messages/channels.hpp"

namespace strobe::host {

LcmLink::LcmLink(const std::string& url, const std::string& rig)
    : lcm_(url),
      rig_channels_("STROBE/" + rig + "/"),
      command_channel_(messages::channel_name(rig, messages::Channel::command)) {}

Result<std::unique_ptr<LcmLink>> LcmLink::open(const std::string& url, const std::string& rig) {
  std::unique_ptr<LcmLink> link(new LcmLink(url, rig));
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
  hand_over(channel, {static_cast<const std::uint8_t*>(buffer->data), buffer->data_size});
}

void LcmLink::hand_over(const std::string& channel, Bytes bytes) {
  if (channel.starts_with(rig_channels_) && channel != command_channel_) (*receiver_)(channel, bytes);
}

LcmLink::Taken LcmLink::take() {
  if (socket_) {
    const auto received = socket_->receive();
    if (!received) return Taken::nothing;
    if (const auto message = assembler_.take(received->sender, received->bytes))
      hand_over(std::string(message->channel), message->data);
    return Taken::message;
  }
  errno = 0;
  const int handled = lcm_.handleTimeout(0);
  if (handled < 0 && errno != EINTR) return Taken::failed;
  return handled > 0 ? Taken::message : Taken::nothing;
}

bool LcmLink::receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
                      const Receiver& receiver) {
  std::vector<pollfd> polled{{socket_ ? socket_->fd() : lcm_.getFileno(), POLLIN, 0}};
  for (const int descriptor : descriptors) polled.push_back({descriptor, POLLIN, 0});
  if (poll(polled.data(), polled.size(), static_cast<int>(max_wait.count())) < 0 && errno != EINTR)
    return false;
  receiver_ = &receiver;
  Taken taken = Taken::message;
  for (int i = 0; i < messages::kSubscriptionQueueCapacity && taken == Taken::message; ++i) taken = take();
  receiver_ = nullptr;
  return taken != Taken::failed;
}

void LcmLink::publish(const std::string& channel, Bytes bytes) {
  lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
}

}  // namespace strobe::host
