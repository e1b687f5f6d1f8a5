#include "common/wire/channel_socket.hpp"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace strobe::wire {

namespace {

constexpr std::size_t kUdpHeader_bytes = 8;  // a filter on a UDP socket sees it
constexpr std::uint32_t kAll = UINT32_MAX;
constexpr std::uint32_t kNone = 0;

/// A program in the kernel's filter language (classic BPF). What it loads from beyond a datagram's end drops
/// it.
class Filter {
 public:
  explicit Filter(const ChannelChoice& choice) : choice_(choice) {
    load(BPF_W, kUdpHeader_bytes);
    const std::size_t whole = branch(kWholeMark);
    accept_channel(kUdpHeader_bytes + kWholeHeader_bytes);
    land(whole);
    jump_over_next_if(kPartMark);
    give(kNone);
    load(BPF_H, kUdpHeader_bytes + kPartAt);
    jump_over_next_if(0);
    give(choice.whole ? kNone : kAll);  // a later part does not say whose it is
    accept_channel(kUdpHeader_bytes + kPartHeader_bytes);
  }
  bool attach(int socket) {
    const sock_fprog program{static_cast<unsigned short>(program_.size()), program_.data()};
    return setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
  }

 private:
  void load(int size, std::size_t at) {
    program_.push_back(
        BPF_STMT(static_cast<std::uint16_t>(BPF_LD | BPF_ABS | size), static_cast<std::uint32_t>(at)));
  }
  void give(std::uint32_t bytes) { program_.push_back(BPF_STMT(BPF_RET | BPF_K, bytes)); }
  void jump_over_next_if(std::uint32_t value) {
    program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0));
  }
  /// Goes on here if the value is loaded, else at the given instruction.
  std::size_t branch(std::uint32_t value) {
    program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 0));
    return program_.size() - 1;
  }
  void land(std::size_t from) { program_[from].jf = static_cast<std::uint8_t>(program_.size() - from - 1); }

  struct Piece {
    int size;
    std::uint32_t value;
    std::size_t at;
  };
  static std::vector<Piece> pieces(const std::string& text) {
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < text.size();) {
      const std::size_t left = text.size() - i, size = left >= 4 ? 4 : left >= 2 ? 2 : 1;
      std::uint32_t value = 0;
      for (std::size_t k = 0; k < size; ++k) value = value << 8 | static_cast<std::uint8_t>(text[i + k]);
      pieces.push_back({size == 4 ? BPF_W : size == 2 ? BPF_H : BPF_B, value, i});
      i += size;
    }
    return pieces;
  }
  static std::string with_end(const std::string& channel) { return channel + std::string(1, '\0'); }

  void accept_channel(std::size_t at) {
    if (!choice_.unwanted.empty()) {
      std::vector<std::size_t> differs;
      for (const Piece& piece : pieces(with_end(choice_.unwanted))) {
        load(piece.size, at + piece.at);
        differs.push_back(branch(piece.value));
      }
      give(kNone);
      for (const std::size_t from : differs) land(from);
    }
    for (const Piece& piece : pieces(choice_.whole ? with_end(choice_.wanted) : choice_.wanted)) {
      load(piece.size, at + piece.at);
      jump_over_next_if(piece.value);
      give(kNone);
    }
    give(kAll);
  }

  const ChannelChoice& choice_;
  std::vector<sock_filter> program_;
};

tl::unexpected<Error> unusable(const MulticastGroup& group, const char* what) {
  return fail("nothing can be received on " + group.address + ":" + std::to_string(group.port) + ": " + what +
              ": " + std::strerror(errno));
}

}  // namespace

Result<ChannelSocket> ChannelSocket::open(const MulticastGroup& group, const ChannelChoice& choice) {
  ChannelSocket socket(group, choice);
  if (socket.fd_ < 0) return unusable(group, "socket");
  const auto option = [&socket](int name, const auto& value) {
    return setsockopt(socket.fd_, SOL_SOCKET, name, &value, sizeof value) == 0;
  };
  const int on = 1;  // firmware and hosts share the port
  if (!option(SO_REUSEADDR, on)) return unusable(group, "sharing the port");
  if (group.receive_buffer_bytes > 0) option(SO_RCVBUF, group.receive_buffer_bytes);
  Filter(choice).attach(socket.fd_);  // where there is none, the reader looks at every datagram
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(group.port);
  if (inet_pton(AF_INET, group.address.c_str(), &address.sin_addr) != 1) {
    errno = EINVAL;
    return unusable(group, "address");
  }
  if (bind(socket.fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return unusable(group, "bind");
  if (!socket.join()) return unusable(group, "joining the group");
  return socket;
}

ChannelSocket::ChannelSocket(MulticastGroup group, ChannelChoice choice)
    : group_(std::move(group)),
      choice_(std::move(choice)),
      fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)),
      timer_(timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)),
      buffer_(kLargestDatagram_bytes) {
  const itimerspec every{{kJoinAgain_s, 0}, {kJoinAgain_s, 0}};
  timerfd_settime(timer_, 0, &every, nullptr);
}

ChannelSocket::ChannelSocket(ChannelSocket&& other) noexcept
    : group_(std::move(other.group_)),
      choice_(std::move(other.choice_)),
      fd_(std::exchange(other.fd_, -1)),
      timer_(std::exchange(other.timer_, -1)),
      links_(std::move(other.links_)),
      buffer_(std::move(other.buffer_)) {}

ChannelSocket::~ChannelSocket() {
  if (fd_ >= 0) close(fd_);
  if (timer_ >= 0) close(timer_);
}

/// On the interface that the route names now. True if it is joined there, also if it was.
bool ChannelSocket::join() {
  ip_mreqn membership{};
  inet_pton(AF_INET, group_.address.c_str(), &membership.imr_multiaddr);
  return setsockopt(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) == 0 ||
         errno == EADDRINUSE;
}

/// Of one that is gone a membership would stay: it counts, and passes for one of an interface made anew with
/// its index.
void ChannelSocket::leave(int interface) {
  ip_mreqn membership{};
  inet_pton(AF_INET, group_.address.c_str(), &membership.imr_multiaddr);
  membership.imr_ifindex = interface;
  setsockopt(fd_, IPPROTO_IP, IP_DROP_MEMBERSHIP, &membership, sizeof membership);  // most were not joined
}

bool ChannelSocket::due() const {
  std::uint64_t times = 0;
  return read(timer_, &times, sizeof times) == sizeof times;
}

/// One socket may have so many memberships (net.ipv4.igmp_max_memberships), and a new one has none.
void ChannelSocket::replace() {
  auto fresh = open(group_, choice_);
  if (fresh) std::swap(fd_, fresh->fd_);
}

void ChannelSocket::stay_joined() {
  const LinkChanges::Since since = links_.take();
  for (const int interface : since.vanished) leave(interface);
  if ((since.any || due()) && !join() && errno == ENOBUFS) replace();
}

std::optional<ChannelSocket::Received> ChannelSocket::receive() {
  sockaddr_in from{};
  socklen_t from_bytes = sizeof from;
  const ssize_t size =
      recvfrom(fd_, buffer_.data(), buffer_.size(), 0, reinterpret_cast<sockaddr*>(&from), &from_bytes);
  if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return std::nullopt;
  if (size < 0) return Received{};
  const auto sender = std::uint64_t{from.sin_addr.s_addr} << 16 | from.sin_port;
  return Received{sender, std::span(buffer_).first(static_cast<std::size_t>(size))};
}

std::string address_of(std::uint64_t sender) {
  if (sender == 0) return "";
  const in_addr address{static_cast<in_addr_t>(sender >> 16)};
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &address, text.data(), text.size());
  return text.data();
}

}  // namespace strobe::wire
