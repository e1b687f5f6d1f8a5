#include "host/session/link.hpp"

#include <poll.h>

#include <cerrno>
#include <vector>

#include "common/messages/channels.hpp"

namespace strobe::host {

Link::Link(const std::string& url, const std::string& rig, Receiver receiver)
    : lcm_(url),
      receiver_(std::move(receiver)),
      command_channel_(messages::channel_name(rig, messages::Channel::command)),
      readout_channel_(messages::channel_name(rig, messages::Channel::readout)),
      frame_channel_(messages::channel_name(rig, messages::Channel::frame)) {}

Result<std::unique_ptr<Link>> Link::open(const std::string& url, const std::string& rig, Receiver receiver) {
  std::unique_ptr<Link> link(new Link(url, rig, std::move(receiver)));
  if (!link->lcm_.good()) {
    return fail("LCM cannot be opened on " + url +
                " (is there a route for multicast? ip route add 224.0.0.0/4 dev lo)");
  }
  // A rig's name has no character that means something in a regular expression.
  auto* subscription = link->lcm_.subscribe("STROBE/" + rig + "/.*", &Link::handle, link.get());
  subscription->setQueueCapacity(messages::kSubscriptionQueueCapacity);
  return link;
}

void Link::handle(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  receiver_(channel, buffer->data, buffer->data_size);
}

bool Link::wait(int milliseconds, std::span<const int> others) {
  if (!others.empty()) {
    std::vector<pollfd> wanted{{lcm_.getFileno(), POLLIN, 0}};
    for (const int other : others) wanted.push_back({other, POLLIN, 0});
    poll(wanted.data(), wanted.size(), milliseconds);
    milliseconds = 0;
  }
  errno = 0;
  return lcm_.handleTimeout(milliseconds) >= 0 || errno == EINTR;
}

bool Link::drain() {
  for (int i = 0; i < messages::kSubscriptionQueueCapacity; ++i) {
    errno = 0;
    const int handled = lcm_.handleTimeout(0);
    if (handled < 0 && errno != EINTR) return false;
    if (handled <= 0) return true;
  }
  return true;
}

void Link::publish(const strobe_msgs::command_t& command) { lcm_.publish(command_channel_, &command); }
void Link::publish(const strobe_msgs::readout_t& readout) { lcm_.publish(readout_channel_, &readout); }
void Link::publish(const strobe_msgs::frame_t& frame) { lcm_.publish(frame_channel_, &frame); }

}  // namespace strobe::host
