#include "sim/ptp/packets.hpp"

#include "sim/ptp/dataset.hpp"

namespace strobe::sim::ptp {

namespace {

constexpr std::uint32_t kHeader = 8;
constexpr std::uint32_t kSendsData = 2;               // data phase of an operation
constexpr std::size_t kBlock = 256 * 1024;            // of data
constexpr std::uint32_t kNoTransaction = 0xFFFFFFFF;  // of what happens by itself

}  // namespace

std::optional<Packet> PacketReader::next() {
  if (broken_ || received_.size() < kHeader) return std::nullopt;
  DatasetReader header(received_);
  const std::uint32_t length = header.u32();
  const std::uint32_t type = header.u32();
  broken_ = length < kHeader || length > kMaxLength;
  if (broken_ || received_.size() < length) return std::nullopt;
  Packet packet{static_cast<PacketType>(type),
                Bytes(received_.begin() + kHeader, received_.begin() + length)};
  received_.erase(received_.begin(), received_.begin() + length);
  return packet;
}

Bytes packet(PacketType type, std::span<const std::uint8_t> payload) {
  DatasetWriter writer;
  writer.u32(kHeader + payload.size()).u32(static_cast<std::uint32_t>(type)).bytes(payload);
  return writer.take();
}

std::optional<OperationRequest> read_operation_request(std::span<const std::uint8_t> payload) {
  DatasetReader reader(payload);
  OperationRequest request;
  request.sends_data = reader.u32() == kSendsData;
  request.code = static_cast<Operation>(reader.u16());
  request.transaction = reader.u32();
  if (!reader.complete()) return std::nullopt;
  while (reader.rest().size() >= sizeof(std::uint32_t) && request.parameters.size() < 5)
    request.parameters.push_back(reader.u32());
  return request;
}

Bytes answer_packets(const Answer& answer, std::uint32_t transaction) {
  DatasetWriter all;
  if (answer.data) {
    const std::span<const std::uint8_t> data(*answer.data);
    all.bytes(packet(PacketType::start_data, DatasetWriter().u32(transaction).u64(data.size()).take()));
    std::size_t sent = 0;
    do {
      const auto block = data.subspan(sent, std::min(kBlock, data.size() - sent));
      sent += block.size();
      all.bytes(packet(sent < data.size() ? PacketType::data : PacketType::end_data,
                       DatasetWriter().u32(transaction).bytes(block).take()));
    } while (sent < data.size());
  }
  DatasetWriter response;
  response.u16(number(answer.code)).u32(transaction);
  for (const std::uint32_t parameter : answer.parameters) response.u32(parameter);
  return all.bytes(packet(PacketType::operation_response, response.take())).take();
}

Bytes event_packet(const Event& event) {
  return packet(PacketType::event,
                DatasetWriter().u16(number(event.code)).u32(kNoTransaction).u32(event.parameter).take());
}

}  // namespace strobe::sim::ptp
