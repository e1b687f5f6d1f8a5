#include "host/messages/lcm_link.hpp"

#include <poll.h>

#include <cerrno>
#include <vector>

#include "common/messages/channels.hpp"

namespace strobe::host {

namespace {

constexpr int kMaxDatagrams = 10000;  // a shot has some 700 events

}  // namespace

LcmLink::LcmLink(const wire::LcmUrl& url, wire::ChannelSocket socket, const std::string& rig)
    : lcm_(wire::to_text(url)),
      socket_(std::move(socket)),
      rig_channels_("STROBE/" + rig + "/"),
      command_channel_(messages::channel_name(rig, messages::Channel::command)) {}

Result<std::unique_ptr<LcmLink>> LcmLink::open(const std::string& url, const std::string& rig) {
  const auto read = wire::read_lcm_url(url);
  if (!read) return tl::unexpected(read.error());
  const wire::ChannelChoice choice{"STROBE/" + rig + "/", false,
                                   messages::channel_name(rig, messages::Channel::command)};
  auto socket = wire::ChannelSocket::open(read->group, choice);
  if (!socket) return tl::unexpected(socket.error());
  std::unique_ptr<LcmLink> link(new LcmLink(*read, std::move(*socket), rig));
  if (!link->lcm_.good()) {
    return fail("LCM cannot use \"" + url +
                "\": is there a multicast route? (ip route add 224.0.0.0/4 dev lo)");
  }
  return link;
}

void LcmLink::hand_over(const std::string& channel, Bytes bytes) {
  if (channel.starts_with(rig_channels_) && channel != command_channel_) (*receiver_)(channel, bytes);
}

bool LcmLink::take() {
  const auto received = socket_.receive();
  if (!received) return false;
  sender_ = received->sender;
  if (const auto message = assembler_.take(received->sender, received->bytes))
    hand_over(std::string(message->channel), message->data);
  return true;
}

bool LcmLink::receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
                      const Receiver& receiver) {
  socket_.stay_joined();
  std::vector<pollfd> polled{{socket_.fd(), POLLIN, 0}};
  for (const int descriptor : descriptors) polled.push_back({descriptor, POLLIN, 0});
  if (poll(polled.data(), polled.size(), static_cast<int>(max_wait.count())) < 0 && errno != EINTR)
    return false;
  receiver_ = &receiver;
  for (int i = 0; i < kMaxDatagrams && take(); ++i) {
  }
  receiver_ = nullptr;
  return true;
}

void LcmLink::publish(const std::string& channel, Bytes bytes) {
  lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
}

}  // namespace strobe::host
