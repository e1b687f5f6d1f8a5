#include "tests/loss/lossy_link.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>
#include <mutex>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

namespace strobe::loss {

namespace {

using Clock = std::chrono::steady_clock;
using Datagram = std::vector<char>;

sockaddr_in address_of(const std::string& url) {
  const std::string scheme = "udpm://";
  const std::size_t colon = url.find(':', scheme.size());
  sockaddr_in address{};
  address.sin_family = AF_INET;
  if (!url.starts_with(scheme) || colon == std::string::npos ||
      inet_pton(AF_INET, url.substr(scheme.size(), colon - scheme.size()).c_str(), &address.sin_addr) != 1)
    throw std::runtime_error("not an LCM URL with group and port: " + url);
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(url.substr(colon + 1))));
  return address;
}

[[noreturn]] void fail_with(const char* what) {
  throw std::runtime_error(std::string(what) + ": " + std::strerror(errno));
}

}  // namespace

/// One network: hears its group, speaks to it from a port of its own.
class MulticastEndpoint {
 public:
  explicit MulticastEndpoint(const sockaddr_in& group) : group_(group) {
    hears_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    speaks_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (hears_ < 0 || speaks_ < 0) fail_with("no socket");
    const int one = 1, room = 8 << 20;
    setsockopt(hears_, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
    if (setsockopt(hears_, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room) != 0)
      setsockopt(hears_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_port = group.sin_port;
    if (bind(hears_, reinterpret_cast<const sockaddr*>(&any), sizeof any) != 0) fail_with("bind");
    ip_mreq membership{group.sin_addr, {INADDR_ANY}};
    if (setsockopt(hears_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0)
      fail_with("no multicast");
    const unsigned char ttl = 0;
    setsockopt(speaks_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
    any.sin_port = 0;
    if (bind(speaks_, reinterpret_cast<const sockaddr*>(&any), sizeof any) != 0) fail_with("bind");
    socklen_t size = sizeof any;
    getsockname(speaks_, reinterpret_cast<sockaddr*>(&any), &size);
    own_port_ = any.sin_port;
  }
  MulticastEndpoint(const MulticastEndpoint&) = delete;
  MulticastEndpoint& operator=(const MulticastEndpoint&) = delete;
  ~MulticastEndpoint() {
    close(hears_);
    close(speaks_);
  }
  int fd() const { return hears_; }
  /// Empty: nothing waits. What this relay itself has sent is left out.
  bool receive(Datagram& datagram) {
    datagram.resize(65536);
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t n =
        recvfrom(hears_, datagram.data(), datagram.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    datagram.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    if (n > 0 && from.sin_port == own_port_) datagram.clear();
    return n >= 0;
  }
  void send(const Datagram& datagram) {
    sendto(speaks_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&group_),
           sizeof group_);
  }

 private:
  sockaddr_in group_;
  int hears_ = -1, speaks_ = -1;
  in_port_t own_port_ = 0;
};

class LossyLink::Impl {
 public:
  Impl(const std::string& url_a, const std::string& url_b, const LinkFaults& faults, std::uint64_t seed)
      : a_(address_of(url_a)), b_(address_of(url_b)), faults_(faults), random_(seed) {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

  void cut(bool is_cut) { cut_ = is_cut; }
  LinkCounts counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
  }

 private:
  struct Late {
    MulticastEndpoint* to;
    Datagram datagram;
  };

  bool chance(double probability) { return std::bernoulli_distribution(probability)(random_); }

  void run(const std::stop_token& stop) {
    std::array<pollfd, 2> polled{{{a_.fd(), POLLIN, 0}, {b_.fd(), POLLIN, 0}}};
    while (!stop.stop_requested()) {
      poll(polled.data(), polled.size(), late_.empty() ? 50 : 1);
      forward(a_, b_);
      forward(b_, a_);
      while (!late_.empty() && late_.begin()->first <= Clock::now()) {
        late_.begin()->second.to->send(late_.begin()->second.datagram);
        late_.erase(late_.begin());
      }
    }
  }

  void forward(MulticastEndpoint& from, MulticastEndpoint& to) {
    for (Datagram datagram; from.receive(datagram);) {
      if (datagram.empty()) continue;
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

  void pass(MulticastEndpoint& to, const Datagram& datagram) {
    if (!chance(faults_.reordering)) return to.send(datagram);
    ++counts_.delayed;
    const auto delay =
        std::chrono::milliseconds(std::uniform_int_distribution<int>(1, faults_.max_delay_ms)(random_));
    late_.emplace(Clock::now() + delay, Late{&to, datagram});
  }

  MulticastEndpoint a_, b_;
  LinkFaults faults_;
  std::mt19937_64 random_;
  std::atomic<bool> cut_{false};
  mutable std::mutex mutex_;
  LinkCounts counts_;
  std::multimap<Clock::time_point, Late> late_;
  std::jthread thread_;
};

LossyLink::LossyLink(const std::string& url_a, const std::string& url_b, const LinkFaults& faults,
                     std::uint64_t seed)
    : impl_(std::make_unique<Impl>(url_a, url_b, faults, seed)) {}
LossyLink::~LossyLink() = default;
void LossyLink::cut(bool is_cut) { impl_->cut(is_cut); }
LinkCounts LossyLink::counts() const { return impl_->counts(); }

}  // namespace strobe::loss
