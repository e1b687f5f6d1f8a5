#include <cstdint>
#include <string>
#include <vector>

#include "tests/kernel/lcm_bridge.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::kernel;

namespace {

const Multicast kGroup{"239.255.76.67", 7667};

std::vector<std::uint8_t> bytes(const std::string& text) { return {text.begin(), text.end()}; }

}  // namespace

TEST_GROUP(CableFrames){};

TEST(CableFrames, CarryADatagramAndGiveItBack) {
  const auto payload = bytes("LC02 something");
  const auto frame = frame_of(kGroup, payload);
  const auto back = payload_of(kGroup, frame);
  CHECK_TRUE(back.has_value());
  CHECK_EQUAL(std::vector<std::uint8_t>(back->begin(), back->end()), payload);
}

TEST(CableFrames, AreAddressedToTheGroup) {
  const auto frame = frame_of(kGroup, bytes("x"));
  const std::vector<std::uint8_t> ethernet{0x01, 0x00, 0x5e,
                                           0x7f, 0x4c, 0x43};  // 239.255.76.67's lower 23 bits
  CHECK_EQUAL(std::vector<std::uint8_t>(frame.begin(), frame.begin() + 6), ethernet);
  LONGS_EQUAL(42 + 1, frame.size());
}

TEST(CableFrames, HaveAnIpHeaderWhoseSumIsRight) {
  const auto frame = frame_of(kGroup, bytes("odd"));
  std::uint32_t sum = 0;
  for (std::size_t i = 14; i < 34; i += 2) sum += static_cast<std::uint32_t>(frame[i]) << 8 | frame[i + 1];
  while (sum > 0xffff) sum = (sum & 0xffff) + (sum >> 16);
  LONGS_EQUAL(0xffff, sum);
}

TEST(CableFrames, OfOtherPortsGroupsAndKindsAreNotForUs) {
  const auto frame = frame_of(kGroup, bytes("x"));
  CHECK_FALSE(payload_of({"239.255.76.67", 7668}, frame).has_value());
  CHECK_FALSE(payload_of({"239.255.76.68", 7667}, frame).has_value());
  auto fragment = frame;
  fragment[20] |= 0x20;
  CHECK_FALSE(payload_of(kGroup, fragment).has_value());
  auto tcp = frame;
  tcp[23] = 6;
  CHECK_FALSE(payload_of(kGroup, tcp).has_value());
}

TEST(CableFrames, CutShortAreDropped) {
  const auto frame = frame_of(kGroup, bytes("whole"));
  for (std::size_t size = 0; size < frame.size(); ++size)
    CHECK_FALSE(payload_of(kGroup, {frame.data(), size}).has_value());
}
