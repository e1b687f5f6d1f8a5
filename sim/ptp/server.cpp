#include "sim/ptp/server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "sim/ptp/dataset.hpp"

namespace strobe::sim::ptp {

namespace {

constexpr std::uint32_t kConnectionNumber = 1;
constexpr std::uint32_t kBusy = 2;  // why a host is not let in
constexpr std::uint32_t kVersion = 0x00010000;
constexpr std::size_t kMaxData = 64 * 1024;  // that a host sends along: a property's value

std::optional<sockaddr_in> socket_address(const std::string& address) {
  sockaddr_in found{};
  found.sin_family = AF_INET;
  found.sin_port = htons(kPort);
  if (inet_pton(AF_INET, address.c_str(), &found.sin_addr) != 1) return std::nullopt;
  return found;
}

}  // namespace

Result<std::unique_ptr<Server>> Server::open(const std::string& address, Host host) {
  std::unique_ptr<Server> server(new Server(address, std::move(host)));
  if (const auto listens = server->listen(); !listens) return tl::unexpected(listens.error());
  return server;
}

Server::~Server() { end_all(); }

Result<void> Server::listen() {
  const auto here = socket_address(address_);
  if (!here) return fail(fmt::format("camera: \"{}\" is no IPv4 address", address_));
  listening_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  constexpr int kYes = 1;
  setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &kYes, sizeof kYes);
  if (bind(listening_, reinterpret_cast<const sockaddr*>(&*here), sizeof *here) == 0 &&
      ::listen(listening_, 4) == 0)
    return {};
  const std::string why = std::strerror(errno);
  end_all();
  return fail(fmt::format("camera: {}:{} cannot be had: {}", address_, kPort, why));
}

Result<void> Server::set_reachable(bool reachable) {
  if (reachable == (listening_ >= 0)) return {};
  if (reachable) return listen();
  end_all();
  return {};
}

void Server::end(Connection& connection) {
  if (connection.fd >= 0) close(connection.fd);
  connection = {};
}

void Server::end_all() {
  if (listening_ >= 0) close(listening_);
  listening_ = -1;
  end(fresh_);
  end(events_);
  if (command_.fd >= 0) host_.gone();
  end(command_);
}

void Server::wait(const RigClock& clock, Duration longest) {
  std::array<pollfd, 4> polled{{{listening_, POLLIN, 0}}};
  std::array<Connection*, 3> connections{&fresh_, &command_, &events_};
  for (std::size_t i = 0; i < connections.size(); ++i) {
    const bool writes = !connections[i]->to_send.empty();
    polled[i + 1] = {connections[i]->fd, static_cast<short>(writes ? POLLIN | POLLOUT : POLLIN), 0};
  }
  clock.poll(polled.data(), polled.size(), longest);
  for (Connection* connection : connections) {
    if (connection->fd >= 0) receive(*connection);
    if (connection->fd >= 0) send_what_fits(*connection);
  }
  accept();
}

void Server::accept() {
  if (listening_ < 0 || fresh_.fd >= 0) return;
  fresh_.fd = accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  constexpr int kYes = 1;
  if (fresh_.fd >= 0) setsockopt(fresh_.fd, IPPROTO_TCP, TCP_NODELAY, &kYes, sizeof kYes);
}

void Server::receive(Connection& connection) {
  std::array<std::uint8_t, 16384> buffer{};
  const ssize_t n = read(connection.fd, buffer.data(), buffer.size());
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (n > 0) {
    connection.reader.add(std::span(buffer.data(), static_cast<std::size_t>(n)));
    while (connection.fd >= 0 && !deaf_) {
      const auto packet = connection.reader.next();
      if (!packet) break;
      take(connection, *packet);
    }
  }
  if (n > 0 && !connection.reader.broken()) return;
  if (&connection == &command_) {
    host_.gone();
    end(events_);
  }
  end(connection);
}

void Server::take(Connection& connection, const Packet& packet) {
  switch (packet.type) {
    case PacketType::init_command_request:
      return begin_command(connection);
    case PacketType::init_event_request:
      return begin_events(connection, packet);
    case PacketType::probe_request: {
      const Bytes response = ptp::packet(PacketType::probe_response, {});
      connection.to_send.insert(connection.to_send.end(), response.begin(), response.end());
      return;
    }
    default:
      if (&connection == &command_) take_operation(connection, packet);
  }
}

void Server::begin_command(Connection& connection) {
  if (&connection != &fresh_ || command_.fd >= 0) {
    connection.to_send = ptp::packet(PacketType::init_fail, DatasetWriter().u32(kBusy).take());
    send_what_fits(connection);
    return end(connection);
  }
  command_ = std::exchange(connection, {});
  DatasetWriter acknowledge;
  acknowledge.u32(kConnectionNumber).bytes(Bytes(16, 0x53)).name("strobe-sim").u32(kVersion);
  command_.to_send = ptp::packet(PacketType::init_command_acknowledge, acknowledge.take());
  send_what_fits(command_);
}

void Server::begin_events(Connection& connection, const Packet& packet) {
  const bool expected = &connection == &fresh_ && command_.fd >= 0 && events_.fd < 0 &&
                        DatasetReader(packet.payload).u32() == kConnectionNumber;
  if (!expected) return end(connection);
  events_ = std::exchange(connection, {});
  events_.to_send = ptp::packet(PacketType::init_event_acknowledge, {});
  send_what_fits(events_);
}

void Server::take_operation(Connection& connection, const Packet& packet) {
  auto& awaiting = connection.awaits_data;
  if (packet.type == PacketType::operation_request) {
    auto request = read_operation_request(packet.payload);
    if (!request) return;
    if (request->sends_data) {
      awaiting = std::move(request);
    } else {
      answer(connection, *request);
    }
  } else if (awaiting && (packet.type == PacketType::data || packet.type == PacketType::end_data)) {
    DatasetReader reader(packet.payload);
    reader.u32();  // the transaction
    if (awaiting->data.size() + reader.rest().size() <= kMaxData)
      awaiting->data.insert(awaiting->data.end(), reader.rest().begin(), reader.rest().end());
    if (packet.type == PacketType::end_data) answer(connection, *std::exchange(awaiting, std::nullopt));
  }
}

void Server::answer(Connection& connection, const OperationRequest& request) {
  const Bytes packets = answer_packets(host_.answer(request), request.transaction);
  connection.to_send.insert(connection.to_send.end(), packets.begin(), packets.end());
}

void Server::send_what_fits(Connection& connection) {
  Bytes& rest = connection.to_send;
  while (!rest.empty()) {
    const ssize_t n = ::send(connection.fd, rest.data(), rest.size(), MSG_NOSIGNAL);
    if (n <= 0) return;
    rest.erase(rest.begin(), rest.begin() + n);
  }
}

void Server::send(const Event& event) {
  if (events_.fd < 0 || deaf_) return;
  const Bytes packet = event_packet(event);
  events_.to_send.insert(events_.to_send.end(), packet.begin(), packet.end());
  send_what_fits(events_);
}

}  // namespace strobe::sim::ptp
