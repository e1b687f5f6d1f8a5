// Packets of PTP over TCP (PTP/IP, CIPA DC-005, clause 2.3): length and type, then what the type says.
// Values; thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "sim/ptp/codes.hpp"

namespace strobe::sim::ptp {

inline constexpr std::uint16_t kPort = 15740;

enum class PacketType : std::uint32_t {
  init_command_request = 1,
  init_command_acknowledge = 2,
  init_event_request = 3,
  init_event_acknowledge = 4,
  init_fail = 5,
  operation_request = 6,
  operation_response = 7,
  event = 8,
  start_data = 9,
  data = 10,
  cancel = 11,
  end_data = 12,
  probe_request = 13,
  probe_response = 14,
};

struct Packet {
  PacketType type = PacketType::probe_request;
  Bytes payload;
};

/// Takes bytes as they arrive and gives whole packets.
class PacketReader {
 public:
  /// Longer ones are no packets of a host.
  static constexpr std::uint32_t kMaxLength = 1 << 20;

  void add(std::span<const std::uint8_t> bytes) {
    received_.insert(received_.end(), bytes.begin(), bytes.end());
  }
  /// Returns nullopt if none is whole yet.
  std::optional<Packet> next();
  /// What came is no packet: the connection is of no use any more.
  bool broken() const { return broken_; }

 private:
  Bytes received_;
  bool broken_ = false;
};

Bytes packet(PacketType type, std::span<const std::uint8_t> payload);

/// What a host wants, with the data that it sent along.
struct OperationRequest {
  bool sends_data = false;
  Operation code = Operation::get_device_info;
  std::uint32_t transaction = 0;
  std::vector<std::uint32_t> parameters;  ///< 5 at most
  Bytes data;

  /// 0 where it is missing.
  std::uint32_t parameter(std::size_t i) const { return i < parameters.size() ? parameters[i] : 0; }
};
/// Of the payload; nullopt if it is too short.
std::optional<OperationRequest> read_operation_request(std::span<const std::uint8_t> payload);

struct Answer {
  Response code = Response::ok;
  std::vector<std::uint32_t> parameters;
  std::optional<Bytes> data;  ///< that is sent before it
};
/// The data, if any, and the response.
Bytes answer_packets(const Answer& answer, std::uint32_t transaction);

struct Event {
  EventCode code = EventCode::capture_complete;
  std::uint32_t parameter = 0;
};
Bytes event_packet(const Event& event);

}  // namespace strobe::sim::ptp
