// Frames cut into packets, put together again by the standard's figures.
#include "sim/gev/stream_packets.hpp"

#include <numeric>

#include "tests/sim/gev/commands.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::sim::gev;
using strobe::testing::word_of;

StreamFrame frame_of(std::size_t bytes) {
  StreamFrame frame;
  frame.block = 0x1234;
  frame.timestamp = UINT64_C(0x0123456789abcdef);
  frame.pixel_format = PixelFormat::mono12;
  frame.width = 100;
  frame.height = 50;
  frame.packet_size = 1036;  // 1000 bytes of payload
  frame.pixels.resize(bytes);
  std::iota(frame.pixels.begin(), frame.pixels.end(), std::uint8_t{0});
  return frame;
}

}  // namespace

TEST_GROUP(GevStreamPackets){};

TEST(GevStreamPackets, BeginWithALeaderThatTellsTimeAndSize) {
  const Packet leader = stream_packet(frame_of(10'000), 0);
  LONGS_EQUAL(44, leader.size());
  LONGS_EQUAL(0x00001234, word_of(leader, 0));
  LONGS_EQUAL(0x01000000, word_of(leader, 4));
  LONGS_EQUAL(0x00000001, word_of(leader, 8));  // an image
  LONGS_EQUAL(0x01234567, word_of(leader, 12));
  LONGS_EQUAL(static_cast<std::int32_t>(0x89abcdef), static_cast<std::int32_t>(word_of(leader, 16)));
  LONGS_EQUAL(0x01100005, word_of(leader, 20));
  LONGS_EQUAL(100, word_of(leader, 24));
  LONGS_EQUAL(50, word_of(leader, 28));
}

TEST(GevStreamPackets, HoldEveryByteOnceAndInOrder) {
  for (const std::size_t size : {1U, 999U, 1000U, 1001U, 10'000U}) {
    const StreamFrame frame = frame_of(size);
    const std::uint32_t count = packet_count(frame);
    LONGS_EQUAL((size + 999) / 1000 + 2, count);
    Packet all;
    for (std::uint32_t id = 1; id + 1 < count; ++id) {
      const Packet packet = stream_packet(frame, id);
      LONGS_EQUAL(0x03000000 | id, word_of(packet, 4));
      CHECK(packet.size() <= 1036 - 28);  // with the headers of IP and UDP as large as the register says
      all.insert(all.end(), packet.begin() + 8, packet.end());
    }
    CHECK_TRUE(all == frame.pixels);
    const Packet trailer = stream_packet(frame, count - 1);
    LONGS_EQUAL(0x02000000 | (count - 1), word_of(trailer, 4));
    LONGS_EQUAL(50, word_of(trailer, 12));
  }
}

TEST(GevStreamPackets, SayWhatIsNotThereAnyMore) {
  const Packet packet = unavailable_packet(7, 3);
  LONGS_EQUAL(static_cast<std::int32_t>(0x800c0007), static_cast<std::int32_t>(word_of(packet, 0)));
  LONGS_EQUAL(0x03000003, word_of(packet, 4));
  LONGS_EQUAL(8, packet.size());
}
