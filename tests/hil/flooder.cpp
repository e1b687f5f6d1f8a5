#include "tests/hil/flooder.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "common/authentication/seal.hpp"
#include "common/messages/channels.hpp"
#include "common/wire/lcm_datagram.hpp"
#include "common/wire/lcm_url.hpp"

namespace strobe::hil {

RawSender::RawSender(const std::string& lcm_url) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const auto url = wire::read_lcm_url(lcm_url);
  if (!url || fd_ < 0) throw std::runtime_error("no multicast group in " + lcm_url);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url->group.port);
  inet_pton(AF_INET, url->group.address.c_str(), &address.sin_addr);
  const int ttl = 0;
  setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  if (connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error("no route to " + lcm_url);
}

RawSender::~RawSender() { close(fd_); }

bool RawSender::send(const Bytes& datagram) const {
  return ::send(fd_, datagram.data(), datagram.size(), 0) == static_cast<ssize_t>(datagram.size());
}

Bytes RawSender::whole(std::string_view channel, const Bytes& message) {
  constexpr std::array<std::uint8_t, 8> kHeader{'L', 'C', '0', '2', 0, 0, 0, 1};
  Bytes datagram(kHeader.size() + channel.size() + 1 + message.size());
  auto end = std::copy(kHeader.begin(), kHeader.end(), datagram.begin());
  end = std::copy(channel.begin(), channel.end(), end) + 1;  // a zero ends the channel
  std::copy(message.begin(), message.end(), end);
  return datagram;
}

Flooder::Flooder(const std::string& lcm_url, const std::string& rig, const Bytes& true_command)
    : sender_(lcm_url) {
  const std::string channel = messages::channel_name(rig, messages::Channel::command);
  const Bytes body(true_command.size() - authentication::kSealed_bytes, 1);
  const auto strangers_key = authentication::Key::random();
  datagrams_[forged] = RawSender::whole(channel, authentication::seal(strangers_key, rig, body).value());
  datagrams_[replayed] = RawSender::whole(channel, true_command);
  datagrams_[garbage] = RawSender::whole(channel, Bytes(true_command.size(), 0x5a));
  datagrams_[oversized] = RawSender::whole(channel, Bytes(65'000, 0x5a));
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

std::int64_t Flooder::stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  return sent_;
}

void Flooder::run(const std::stop_token& stop) {
  constexpr std::int64_t kSmallOnes = 64;  // for each of the largest, which would else be all that fits
  for (std::int64_t i = 0; !stop.stop_requested(); ++i) {
    const std::size_t kind =
        i % kSmallOnes == 0 ? static_cast<std::size_t>(oversized) : static_cast<std::size_t>(i % 3);
    if (sender_.send(datagrams_[kind])) sent_.fetch_add(1, std::memory_order_relaxed);
  }
}

}  // namespace strobe::hil
