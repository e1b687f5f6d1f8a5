// Packets and datasets of PTP/IP, against bytes written out by hand from CIPA DC-005 and ISO 15740.
#include "sim/ptp/packets.hpp"

#include "sim/ptp/dataset.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::sim::ptp;

}  // namespace

TEST_GROUP(PtpPackets) {
  PacketReader reader;
};

TEST(PtpPackets, StringsHaveTheirCountBeforeThemAndAZeroBehind) {
  CHECK(DatasetWriter().text("Ab").take() == Bytes({3, 'A', 0, 'b', 0, 0, 0}));
  CHECK(DatasetWriter().text("").take() == Bytes({0}));
  CHECK_EQUAL("Ab", DatasetReader(Bytes({3, 'A', 0, 'b', 0, 0, 0})).text());
  // The count is one byte: 255 at most, the zero among them.
  LONGS_EQUAL(1 + 2 * 255, DatasetWriter().text(std::string(300, 'x')).take().size());
}

TEST(PtpPackets, NumbersAreLittleEndianAndArraysBeginWithTheirLength) {
  CHECK(DatasetWriter().u16(0x1234).u32(0x56789ABC).take() == Bytes({0x34, 0x12, 0xBC, 0x9A, 0x78, 0x56}));
  CHECK(DatasetWriter().array16(std::vector<std::uint16_t>{0x1001}).take() == Bytes({1, 0, 0, 0, 1, 0x10}));
}

TEST(PtpPackets, WhatIsNotThereReadsAsZeroAndIsRemembered) {
  const Bytes bytes{1, 2, 3};
  DatasetReader short_one(bytes);
  LONGS_EQUAL(0x0201, short_one.u16());
  CHECK(short_one.complete());
  LONGS_EQUAL(0, short_one.u32());
  CHECK_FALSE(short_one.complete());
}

TEST(PtpPackets, AreReadWholeHoweverTheyArrive) {
  // GetDeviceInfo: length 18, type 6, no data to come (1), code 1001, transaction 7.
  const Bytes request{18, 0, 0, 0, 6, 0, 0, 0, 1, 0, 0, 0, 0x01, 0x10, 7, 0, 0, 0};
  for (const std::uint8_t byte : request) {
    CHECK_FALSE(reader.next().has_value());
    reader.add(Bytes{byte});
  }
  reader.add(request);
  for (int i = 0; i < 2; ++i) {
    const auto packet = reader.next();
    CHECK(packet.has_value());
    CHECK(packet->type == PacketType::operation_request);
    const auto operation = read_operation_request(packet->payload);
    CHECK(operation.has_value());
    CHECK(operation->code == Operation::get_device_info);
    LONGS_EQUAL(7, operation->transaction);
    CHECK_FALSE(operation->sends_data);
    LONGS_EQUAL(0, operation->parameter(0));
  }
  CHECK_FALSE(reader.next().has_value());
}

TEST(PtpPackets, LengthsThatNoPacketHasEndTheConnection) {
  for (const Bytes& header : {Bytes{7, 0, 0, 0, 6, 0, 0, 0}, Bytes{0xFF, 0xFF, 0xFF, 0xFF, 6, 0, 0, 0}}) {
    PacketReader broken;
    broken.add(header);
    CHECK_FALSE(broken.next().has_value());
    CHECK(broken.broken());
  }
}

TEST(PtpPackets, ARequestThatIsTooShortIsNone) {
  CHECK_FALSE(read_operation_request(Bytes{1, 0, 0, 0, 1}).has_value());
}

TEST(PtpPackets, AnswersAreTheDataInBlocksAndTheResponse) {
  reader.add(answer_packets({Response::ok, {5}, Bytes(600'000, 0xAB)}, 9));
  auto packet = reader.next();
  CHECK(packet->type == PacketType::start_data);
  CHECK(packet->payload == Bytes({9, 0, 0, 0, 0xC0, 0x27, 0x09, 0, 0, 0, 0, 0}));  // 600,000 = 0x927C0
  std::size_t received = 0;
  do {
    packet = reader.next();
    CHECK(packet.has_value());
    received += packet->payload.size() - 4;
  } while (packet->type == PacketType::data);
  CHECK(packet->type == PacketType::end_data);
  LONGS_EQUAL(600'000, received);
  packet = reader.next();
  CHECK(packet->type == PacketType::operation_response);
  CHECK(packet->payload == Bytes({0x01, 0x20, 9, 0, 0, 0, 5, 0, 0, 0}));
}

TEST(PtpPackets, EventsBelongToNoTransaction) {
  const Bytes expected{18, 0, 0, 0, 8, 0, 0, 0, 0x02, 0x40, 0xFF, 0xFF, 0xFF, 0xFF, 4, 0, 0, 0};
  CHECK(event_packet({EventCode::object_added, 4}) == expected);
}
