#include "common/wire/assembler.hpp"

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace strobe::wire;
using Bytes = std::vector<std::uint8_t>;

namespace {

void put(Bytes& bytes, std::uint32_t value, int size) {
  for (int shift = 8 * (size - 1); shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// The datagrams that LCM makes of a message, of so many bytes each.
std::vector<Bytes> parts_of(const Bytes& message, const std::string& channel, std::uint32_t number,
                            std::size_t bytes_each) {
  std::vector<Bytes> parts;
  const std::size_t count = (message.size() + bytes_each - 1) / bytes_each;
  for (std::size_t i = 0; i < count; ++i) {
    Bytes part;
    put(part, kPartMark, 4);
    put(part, number, 4);
    put(part, static_cast<std::uint32_t>(message.size()), 4);
    put(part, static_cast<std::uint32_t>(i * bytes_each), 4);
    put(part, static_cast<std::uint32_t>(i), 2);
    put(part, static_cast<std::uint32_t>(count), 2);
    if (i == 0) {
      part.insert(part.end(), channel.begin(), channel.end());
      part.push_back(0);
    }
    const std::size_t end = std::min(message.size(), (i + 1) * bytes_each);
    part.insert(part.end(), message.begin() + static_cast<std::ptrdiff_t>(i * bytes_each),
                message.begin() + static_cast<std::ptrdiff_t>(end));
    parts.push_back(part);
  }
  return parts;
}

}  // namespace

TEST_GROUP(Assembler) {
  Assembler assembler;
  std::mt19937 random{7};
  Bytes message = Bytes(1000);

  void setup() override {
    for (auto& byte : message) byte = static_cast<std::uint8_t>(random());
  }
  bool completes(std::uint64_t sender, const Bytes& datagram) {
    const auto taken = assembler.take(sender, datagram);
    return taken && taken->channel == "X" && std::ranges::equal(taken->data, message);
  }
};

TEST(Assembler, PutsPartsTogetherInAnyOrder) {
  for (std::uint32_t trial = 0; trial < 20; ++trial) {
    auto parts = parts_of(message, "X", trial, 100);
    std::ranges::shuffle(parts, random);
    for (std::size_t i = 0; i < parts.size(); ++i) CHECK_EQUAL(i + 1 == parts.size(), completes(1, parts[i]));
  }
}

TEST(Assembler, CountsAPartThatComesTwiceOnce) {
  const auto parts = parts_of(message, "X", 1, 500);
  CHECK_FALSE(completes(1, parts[0]));
  CHECK_FALSE(completes(1, parts[0]));
  CHECK_TRUE(completes(1, parts[1]));
}

TEST(Assembler, KeepsSendersAndMessagesApart) {
  const auto parts = parts_of(message, "X", 1, 500);
  const auto next = parts_of(message, "X", 2, 500);
  CHECK_FALSE(completes(1, parts[0]));
  CHECK_FALSE(completes(2, parts[1]));
  CHECK_FALSE(completes(1, next[1]));
  CHECK_TRUE(completes(1, parts[1]));
  CHECK_TRUE(completes(1, next[0]));
  CHECK_TRUE(completes(2, parts[0]));
}

TEST(Assembler, HoldsOnlyTheNewestUnfinishedMessages) {
  const auto parts = parts_of(message, "X", 0, 500);
  CHECK_FALSE(completes(1, parts[0]));
  for (std::uint32_t number = 1; number <= Assembler::kMaxUnfinished; ++number)
    CHECK_FALSE(completes(1, parts_of(message, "X", number, 500)[0]));
  CHECK_FALSE(completes(1, parts[1]));  // the first one was given up
  CHECK_TRUE(completes(1, parts_of(message, "X", Assembler::kMaxUnfinished, 500)[1]));
}

TEST(Assembler, TakesTheLargestMessage) {
  message.resize(Assembler::kMaxMessage_bytes);
  const std::vector<Bytes> parts = parts_of(message, "X", 1, 60'000);
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) CHECK_FALSE(completes(1, parts[i]));
  CHECK(completes(1, parts.back()));
}

TEST(Assembler, MakesNoRoomForHugeMessages) {
  message.resize(Assembler::kMaxMessage_bytes + 1);
  for (const Bytes& part : parts_of(message, "X", 1, 60'000)) CHECK_FALSE(completes(1, part));
}

TEST(Assembler, PassesWholeMessagesOn) {
  Bytes datagram{'L', 'C', '0', '2', 0, 0, 0, 1, 'X', 0};
  datagram.insert(datagram.end(), message.begin(), message.end());
  CHECK_TRUE(completes(1, datagram));
}

TEST(Assembler, SurvivesAnyDatagrams) {
  const auto parts = parts_of(message, "X", 1, 300);
  for (int trial = 0; trial < 100'000; ++trial) {
    Bytes datagram = parts[random() % parts.size()];
    for (std::size_t k = random() % 4; k > 0; --k)
      datagram[random() % 30] = static_cast<std::uint8_t>(random());
    datagram.resize(random() % (datagram.size() + 1));
    assembler.take(random() % 3, datagram);
  }
}
