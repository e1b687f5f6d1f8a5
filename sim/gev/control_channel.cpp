// Commands and acknowledges of the control channel (GVCP).
#include <algorithm>

#include "sim/gev/device.hpp"

namespace strobe::sim::gev {
namespace {

constexpr std::size_t kHeaderSize = 8;
constexpr std::uint8_t kKey = 0x42;
constexpr std::uint8_t kAcknowledge = 0x01;
constexpr std::uint8_t kExtendedId = 0x10;
constexpr std::uint32_t kMaxMemory = 536;  ///< bytes of one READMEM
constexpr std::size_t kDiscoverySize = 0xf8;

enum Code : std::uint16_t {
  kDiscovery = 0x0002,
  kPacketResend = 0x0040,
  kReadRegister = 0x0080,
  kWriteRegister = 0x0082,
  kReadMemory = 0x0084,
  kWriteMemory = 0x0086,
};

Packet acknowledge(std::uint16_t code, std::uint16_t id, Status status, const Packet& reply) {
  Packet packet;
  append(packet, 2, static_cast<std::uint16_t>(status));
  append(packet, 2, code + 1U);
  append(packet, 2, reply.size());
  append(packet, 2, id);
  packet.insert(packet.end(), reply.begin(), reply.end());
  return packet;
}

}  // namespace

struct Device::Command {
  std::uint8_t flags;
  std::uint16_t code, id;
  Bytes data;
};

std::optional<Packet> Device::answer(Bytes datagram, const Endpoint& sender, MonoTime now) {
  if (datagram.size() < kHeaderSize || datagram[0] != kKey) return std::nullopt;
  const Command command{datagram[1], static_cast<std::uint16_t>(number_at(datagram, 2, 2)),
                        static_cast<std::uint16_t>(number_at(datagram, 6, 2)), datagram.subspan(kHeaderSize)};
  const std::size_t length = number_at(datagram, 4, 2);
  Packet reply;
  Status status = Status::invalid_header;
  if (command.id != 0 && length == command.data.size()) {
    if (controller_ == sender) heard_ = now;
    status = execute(command, sender, now, reply);
  }
  // A request for packets is answered by the packets.
  const bool wanted = (command.flags & kAcknowledge) != 0 && command.code != kPacketResend;
  return wanted ? std::optional(acknowledge(command.code, command.id, status, reply)) : std::nullopt;
}

Status Device::execute(const Command& command, const Endpoint& sender, MonoTime now, Packet& reply) {
  const bool reads = command.code == kReadRegister || command.code == kReadMemory;
  if (reads && !may_read(sender)) return Status::access_denied;
  switch (command.code) {
    case kDiscovery:
      if (!command.data.empty()) return Status::invalid_parameter;
      reply.assign(bootstrap_.begin(), bootstrap_.begin() + kDiscoverySize);
      return Status::success;
    case kReadRegister:
      return read_registers(command, reply);
    case kWriteRegister:
      return write_registers(command, sender, now, reply);
    case kReadMemory:
      return read_memory(command, reply);
    case kWriteMemory:
      return write_memory(command, sender, now, reply);
    case kPacketResend:
      return may_ask_again(sender) ? take_resend(command) : Status::access_denied;
    default:
      return Status::not_implemented;
  }
}

Status Device::read_registers(const Command& command, Packet& reply) const {
  if (command.data.empty() || command.data.size() % 4 != 0 || command.data.size() > kMaxMemory)
    return Status::invalid_parameter;
  for (std::size_t at = 0; at < command.data.size(); at += 4) {
    const std::uint32_t address = word_at(command.data, at);
    if (address % 4 != 0) return Status::bad_alignment;
    if (memory(address, 4) == nullptr) return Status::invalid_address;
    append(reply, 4, word(address));
  }
  return Status::success;
}

Status Device::write_registers(const Command& command, const Endpoint& sender, MonoTime now, Packet& reply) {
  if (command.data.empty() || command.data.size() % 8 != 0 || command.data.size() > kMaxMemory)
    return Status::invalid_parameter;
  Status status = Status::success;
  std::uint32_t done = 0;
  for (std::size_t at = 0; at < command.data.size() && status == Status::success; at += 8) {
    status = write(word_at(command.data, at), word_at(command.data, at + 4), sender, now);
    if (status == Status::success) ++done;
  }
  append(reply, 4, done);
  return status;
}

Status Device::read_memory(const Command& command, Packet& reply) const {
  if (command.data.size() != 8) return Status::invalid_parameter;
  const std::uint32_t address = word_at(command.data, 0);
  const auto count = static_cast<std::uint32_t>(number_at(command.data, 6, 2));
  if (address % 4 != 0 || count % 4 != 0) return Status::bad_alignment;
  if (count == 0 || count > kMaxMemory) return Status::invalid_parameter;
  const std::uint8_t* const bytes = memory(address, count);
  if (bytes == nullptr) return Status::invalid_address;
  append(reply, 4, address);
  reply.insert(reply.end(), bytes, bytes + count);
  return Status::success;
}

Status Device::write_memory(const Command& command, const Endpoint& sender, MonoTime now, Packet& reply) {
  if (command.data.size() <= 4 || command.data.size() > kMaxMemory + 4) return Status::invalid_parameter;
  const std::uint32_t address = word_at(command.data, 0);
  const Bytes data = command.data.subspan(4);
  if (address % 4 != 0 || data.size() % 4 != 0) return Status::bad_alignment;
  Status status = Status::success;
  std::uint32_t done = 0;
  for (; done < data.size() && status == Status::success; done += status == Status::success ? 4 : 0)
    status = write(address + done, word_at(data, done), sender, now);
  append(reply, 4, done);
  return status;
}

Status Device::take_resend(const Command& command) {
  constexpr std::size_t kMaxRequests = 1000;  ///< that wait: what more is asked for is lost
  constexpr std::uint32_t kIds = 0xffffff;
  if ((command.flags & kExtendedId) != 0 || command.data.size() != 12) return Status::invalid_parameter;
  const PacketRange range{static_cast<std::uint16_t>(number_at(command.data, 2, 2)),
                          word_at(command.data, 4) & kIds, word_at(command.data, 8) & kIds};
  if (range.last < range.first) return Status::invalid_parameter;
  if (resend_requests_.size() < kMaxRequests) resend_requests_.push_back(range);
  return Status::success;
}

}  // namespace strobe::sim::gev
