#include "tests/campaigns/lossy_link.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace strobe::loss {

namespace {

template <typename T>
T value_of(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

wire::MulticastGroup group_of(const std::string& url) { return value_of(wire::read_lcm_url(url)).group; }

}  // namespace

LossyLink::Network::Network(const std::string& url)
    : ear(value_of(wire::ChannelSocket::open(group_of(url), {"", false, ""}))) {
  const int room = 8 << 20;
  setsockopt(ear.fd(), SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room);
  group.sin_family = AF_INET;
  group.sin_port = htons(group_of(url).port);
  inet_pton(AF_INET, group_of(url).address.c_str(), &group.sin_addr);
}

LossyLink::LossyLink(const std::string& url_a, const std::string& url_b, const LinkFaults& faults,
                     std::uint64_t seed)
    : a_(url_a),
      b_(url_b),
      mouth_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)),
      faults_(faults),
      random_(seed) {
  own_.sin_family = AF_INET;
  const unsigned char ttl = 0;
  setsockopt(mouth_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  socklen_t size = sizeof own_;
  if (bind(mouth_, reinterpret_cast<const sockaddr*>(&own_), size) != 0 ||
      getsockname(mouth_, reinterpret_cast<sockaddr*>(&own_), &size) != 0)
    throw std::runtime_error("no socket to relay by");
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

LossyLink::~LossyLink() {
  thread_ = {};
  close(mouth_);
}

LinkCounts LossyLink::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void LossyLink::run(const std::stop_token& stop) {
  std::array<pollfd, 2> polled{{{a_.ear.fd(), POLLIN, 0}, {b_.ear.fd(), POLLIN, 0}}};
  while (!stop.stop_requested()) {
    poll(polled.data(), polled.size(), late_.empty() ? 50 : 1);
    forward(a_, b_);
    forward(b_, a_);
    while (!late_.empty() && late_.begin()->first <= Clock::now()) {
      send(*late_.begin()->second.to, late_.begin()->second.datagram);
      late_.erase(late_.begin());
    }
  }
}

void LossyLink::forward(Network& from, const Network& to) {
  while (const auto received = from.ear.receive()) {
    // Its port is the lower half of a sender's number.
    if (received->bytes.empty() || static_cast<in_port_t>(received->sender) == own_.sin_port) continue;
    const Datagram datagram(received->bytes.begin(), received->bytes.end());
    const std::lock_guard lock(mutex_);
    ++counts_.came;
    if (cut_) {
      ++counts_.cut;
    } else if (chance(faults_.loss)) {
      ++counts_.lost;
    } else {
      pass(to, datagram);
      if (!chance(faults_.duplication)) continue;
      ++counts_.doubled;
      pass(to, datagram);
    }
  }
}

void LossyLink::pass(const Network& to, const Datagram& datagram) {
  if (!chance(faults_.reordering)) return send(to, datagram);
  ++counts_.delayed;
  const auto delay =
      std::chrono::milliseconds(std::uniform_int_distribution<int>(1, faults_.max_delay_ms)(random_));
  late_.emplace(Clock::now() + delay, Late{&to, datagram});
}

void LossyLink::send(const Network& to, const Datagram& datagram) const {
  sendto(mouth_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to.group),
         sizeof to.group);
}

}  // namespace strobe::loss
