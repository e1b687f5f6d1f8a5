#include "common/wire/link_changes.hpp"

#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>

namespace strobe::wire {
namespace {

constexpr std::size_t kLargest_bytes = 32768;  // the kernel makes none larger

/// Adds what the messages of one datagram tell. A length that is not within it ends the reading.
void read_messages(std::span<const std::byte> bytes, LinkChanges::Since& since) {
  while (bytes.size() >= sizeof(nlmsghdr)) {
    nlmsghdr header{};
    std::memcpy(&header, bytes.data(), sizeof header);
    if (header.nlmsg_len < sizeof header || header.nlmsg_len > bytes.size()) return;
    since.any = true;
    if (header.nlmsg_type == RTM_DELLINK && header.nlmsg_len >= NLMSG_LENGTH(sizeof(ifinfomsg))) {
      ifinfomsg link{};
      std::memcpy(&link, bytes.data() + NLMSG_HDRLEN, sizeof link);
      since.vanished.push_back(link.ifi_index);
    }
    bytes = bytes.subspan(std::min<std::size_t>(NLMSG_ALIGN(header.nlmsg_len), bytes.size()));
  }
}

}  // namespace

LinkChanges::LinkChanges() : fd_(socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE)) {
  sockaddr_nl address{};
  address.nl_family = AF_NETLINK;
  address.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR | RTMGRP_IPV4_ROUTE;
  if (fd_ < 0 || bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
  close(fd_);
  fd_ = -1;
}

LinkChanges::LinkChanges(LinkChanges&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

LinkChanges& LinkChanges::operator=(LinkChanges&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

LinkChanges::~LinkChanges() {
  if (fd_ >= 0) close(fd_);
}

LinkChanges::Since LinkChanges::take() {
  Since since;
  alignas(nlmsghdr) std::array<std::byte, kLargest_bytes> buffer;
  while (fd_ >= 0) {
    sockaddr_nl from{};
    socklen_t from_bytes = sizeof from;
    const ssize_t size =
        recvfrom(fd_, buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&from), &from_bytes);
    if (size < 0 && errno == ENOBUFS) {  // more has changed than it could keep
      since.any = true;
      continue;
    }
    if (size <= 0) break;
    if (from.nl_pid == 0) read_messages(std::span(buffer).first(static_cast<std::size_t>(size)), since);
  }
  return since;
}

}  // namespace strobe::wire
