#include "tests/kernel/lcm_bridge.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace strobe::kernel {

namespace {

// RFC 894, 791, 768: an Ethernet frame with an IPv4 header without options and a UDP header before the
// payload.
constexpr std::size_t kEthernet = 14, kIp = 20, kUdp = 8, kHeaders = kEthernet + kIp + kUdp;
constexpr std::size_t kLargest = 65536 + kHeaders;
constexpr const char* kOurAddress = "10.76.0.1";
constexpr int kBufferBytes = 4 << 20;
constexpr int kPoll_ms = 20;

std::uint32_t address_of(const std::string& text) {
  in_addr address{};
  inet_pton(AF_INET, text.c_str(), &address);
  return ntohl(address.s_addr);
}

void put16(std::uint8_t* at, std::uint32_t value) {
  at[0] = static_cast<std::uint8_t>(value >> 8);
  at[1] = static_cast<std::uint8_t>(value);
}
void put32(std::uint8_t* at, std::uint32_t value) {
  put16(at, value >> 16);
  put16(at + 2, value);
}
std::uint32_t get16(const std::uint8_t* at) { return static_cast<std::uint32_t>(at[0]) << 8 | at[1]; }
std::uint32_t get32(const std::uint8_t* at) { return get16(at) << 16 | get16(at + 2); }

std::uint32_t checksum(const std::uint8_t* data, std::size_t size) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < size; i += 2) sum += get16(data + i);
  while (sum > 0xffff) sum = (sum & 0xffff) + (sum >> 16);
  return ~sum & 0xffff;
}

sockaddr_un unix_address(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.string().size() >= sizeof address.sun_path)
    throw std::runtime_error("path too long: " + path.string());
  std::memcpy(address.sun_path, path.c_str(), path.string().size() + 1);
  return address;
}

sockaddr_in inet_address(std::uint32_t address, std::uint16_t port) {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  in.sin_addr.s_addr = htonl(address);
  in.sin_port = htons(port);
  return in;
}

template <typename Address>
void bind_to(int fd, const Address& address) {
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error(std::string("bridge: ") + std::strerror(errno));
}

void set(int fd, int level, int option, int value) { setsockopt(fd, level, option, &value, sizeof value); }

}  // namespace

std::vector<std::uint8_t> frame_of(const Multicast& to, std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> frame(kHeaders + payload.size());
  const std::uint32_t group = address_of(to.group);
  std::uint8_t* const ethernet = frame.data();
  // RFC 1112: the group's lower 23 bits; a locally administered sender.
  put16(ethernet, 0x0100);
  put32(ethernet + 2, 0x5e000000 | (group & 0x7fffff));
  put32(ethernet + 6, 0x02000000);
  put16(ethernet + 10, 1);
  put16(ethernet + 12, 0x0800);
  std::uint8_t* const ip = ethernet + kEthernet;
  ip[0] = 0x45;
  put16(ip + 2, static_cast<std::uint32_t>(kIp + kUdp + payload.size()));
  put16(ip + 6, 0x4000);
  ip[8] = 1;
  ip[9] = IPPROTO_UDP;
  put32(ip + 12, address_of(kOurAddress));
  put32(ip + 16, group);
  put16(ip + 10, checksum(ip, kIp));
  std::uint8_t* const udp = ip + kIp;
  put16(udp, to.port);
  put16(udp + 2, to.port);
  put16(udp + 4, static_cast<std::uint32_t>(kUdp + payload.size()));  // no checksum: 0
  if (!payload.empty()) std::memcpy(udp + kUdp, payload.data(), payload.size());
  return frame;
}

std::optional<std::span<const std::uint8_t>> payload_of(const Multicast& to,
                                                        std::span<const std::uint8_t> frame) {
  if (frame.size() < kHeaders) return std::nullopt;
  const std::uint8_t* const ip = frame.data() + kEthernet;
  const std::uint8_t* const udp = ip + kIp;
  const bool is_ours = get16(frame.data() + 12) == 0x0800 && ip[0] == 0x45 && ip[9] == IPPROTO_UDP &&
                       (get16(ip + 6) & 0x3fff) == 0 && get32(ip + 16) == address_of(to.group) &&
                       get16(udp + 2) == to.port;
  const std::size_t size = get16(udp + 4);
  if (!is_ours || size < kUdp || kEthernet + kIp + size > frame.size()) return std::nullopt;
  return frame.subspan(kHeaders, size - kUdp);
}

LcmBridge::LcmBridge(Multicast multicast, const std::filesystem::path& ours,
                     const std::filesystem::path& theirs)
    : multicast_(std::move(multicast)), theirs_(theirs), buffer_(kLargest) {
  cable_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  bind_to(cable_, unix_address(ours));
  listener_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  set(listener_, SOL_SOCKET, SO_REUSEADDR, 1);
  set(listener_, SOL_SOCKET, SO_REUSEPORT, 1);  // as LCM does
  set(listener_, SOL_SOCKET, SO_RCVBUF, kBufferBytes);
  const std::uint32_t group = address_of(multicast_.group);
  bind_to(listener_, inet_address(group, multicast_.port));
  ip_mreqn join{};
  join.imr_multiaddr.s_addr = htonl(group);
  join.imr_ifindex = static_cast<int>(if_nametoindex("lo"));
  if (setsockopt(listener_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &join, sizeof join) != 0)
    throw std::runtime_error(std::string("bridge: cannot join: ") + std::strerror(errno));
  sender_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  bind_to(sender_, inet_address(INADDR_ANY, 0));
  setsockopt(sender_, IPPROTO_IP, IP_MULTICAST_IF, &join, sizeof join);
  set(sender_, IPPROTO_IP, IP_MULTICAST_LOOP, 1);
  sockaddr_in bound{};
  socklen_t size = sizeof bound;
  getsockname(sender_, reinterpret_cast<sockaddr*>(&bound), &size);
  sender_port_ = ntohs(bound.sin_port);
  thread_ = std::thread([this] { run(); });
}

LcmBridge::~LcmBridge() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
  for (const int fd : {cable_, listener_, sender_})
    if (fd >= 0) close(fd);
}

void LcmBridge::from_machine() {
  for (;;) {
    const ssize_t size = recv(cable_, buffer_.data(), buffer_.size(), 0);
    if (size < 0) return;
    const auto payload = payload_of(multicast_, {buffer_.data(), static_cast<std::size_t>(size)});
    if (!payload) continue;
    const sockaddr_in group = inet_address(address_of(multicast_.group), multicast_.port);
    if (sendto(sender_, payload->data(), payload->size(), 0, reinterpret_cast<const sockaddr*>(&group),
               sizeof group) >= 0)
      ++sent_out_;
  }
}

void LcmBridge::from_here() {
  const sockaddr_un machine = unix_address(theirs_);
  for (;;) {
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t size =
        recvfrom(listener_, buffer_.data(), buffer_.size(), 0, reinterpret_cast<sockaddr*>(&from), &length);
    if (size < 0) return;
    if (ntohs(from.sin_port) == sender_port_) continue;  // what the machine itself has said
    const auto frame = frame_of(multicast_, {buffer_.data(), static_cast<std::size_t>(size)});
    if (sendto(cable_, frame.data(), frame.size(), 0, reinterpret_cast<const sockaddr*>(&machine),
               sizeof machine) >= 0)
      ++sent_in_;
  }
}

void LcmBridge::run() {
  while (!stopping_) {
    pollfd waiting[] = {{cable_, POLLIN, 0}, {listener_, POLLIN, 0}};
    if (poll(waiting, 2, kPoll_ms) <= 0) continue;
    from_machine();
    from_here();
  }
}

}  // namespace strobe::kernel
