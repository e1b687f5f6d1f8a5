#include "tests/campaigns/lossy_link.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

#include "common/wire/channel_socket.hpp"

namespace strobe::loss {

namespace {

wire::MulticastGroup group_of(const std::string& url) {
  const auto read = wire::read_lcm_url(url);
  if (!read) throw std::runtime_error(read.error().message);
  return read->group;
}

wire::ChannelSocket every_channel_of(const wire::MulticastGroup& group) {
  auto socket = wire::ChannelSocket::open(group, {"", false, ""});
  if (!socket) throw std::runtime_error(socket.error().message);
  const int room = 8 << 20;
  setsockopt(socket->fd(), SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room);
  return std::move(*socket);
}

}  // namespace

/// One network: hears its group, speaks to it from a port of its own.
class MulticastEndpoint {
 public:
  explicit MulticastEndpoint(const std::string& url)
      : ear_(every_channel_of(group_of(url))), mouth_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const wire::MulticastGroup group = group_of(url);
    to_.sin_family = own_.sin_family = AF_INET;
    to_.sin_port = htons(group.port);
    inet_pton(AF_INET, group.address.c_str(), &to_.sin_addr);
    const unsigned char ttl = 0;
    setsockopt(mouth_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
    socklen_t size = sizeof own_;
    if (bind(mouth_, reinterpret_cast<const sockaddr*>(&own_), sizeof own_) != 0 ||
        getsockname(mouth_, reinterpret_cast<sockaddr*>(&own_), &size) != 0)
      throw std::runtime_error("no socket to relay by");
  }
  MulticastEndpoint(const MulticastEndpoint&) = delete;
  MulticastEndpoint& operator=(const MulticastEndpoint&) = delete;
  ~MulticastEndpoint() { close(mouth_); }

  int fd() const { return ear_.fd(); }
  auto receive() { return ear_.receive(); }
  /// Its sender's port is the lower half of the number.
  bool is_own(std::uint64_t sender) const { return static_cast<in_port_t>(sender) == own_.sin_port; }
  void send(const std::vector<std::uint8_t>& datagram) {
    sendto(mouth_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
  }

 private:
  wire::ChannelSocket ear_;
  int mouth_;
  sockaddr_in to_{}, own_{};
};

LossyLink::LossyLink(const std::string& url_a, const std::string& url_b, const LinkFaults& faults,
                     std::uint64_t seed)
    : a_(std::make_unique<MulticastEndpoint>(url_a)),
      b_(std::make_unique<MulticastEndpoint>(url_b)),
      faults_(faults),
      random_(seed),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

LossyLink::~LossyLink() = default;

LinkCounts LossyLink::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void LossyLink::run(const std::stop_token& stop) {
  std::array<pollfd, 2> polled{{{a_->fd(), POLLIN, 0}, {b_->fd(), POLLIN, 0}}};
  while (!stop.stop_requested()) {
    poll(polled.data(), polled.size(), late_.empty() ? 50 : 1);
    forward(*a_, *b_);
    forward(*b_, *a_);
    while (!late_.empty() && late_.begin()->first <= Clock::now()) {
      late_.begin()->second.to->send(late_.begin()->second.datagram);
      late_.erase(late_.begin());
    }
  }
}

void LossyLink::forward(MulticastEndpoint& from, MulticastEndpoint& to) {
  while (const auto received = from.receive()) {
    if (received->bytes.empty() || from.is_own(received->sender)) continue;
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

void LossyLink::pass(MulticastEndpoint& to, const Datagram& datagram) {
  if (!chance(faults_.reordering)) return to.send(datagram);
  ++counts_.delayed;
  const auto delay =
      std::chrono::milliseconds(std::uniform_int_distribution<int>(1, faults_.max_delay_ms)(random_));
  late_.emplace(Clock::now() + delay, Late{&to, datagram});
}

}  // namespace strobe::loss
