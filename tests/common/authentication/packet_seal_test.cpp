#include "common/authentication/packet_seal.hpp"

#include <strobe_msgs/event_t.hpp>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "common/messages/well_formed.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::authentication;
using Packet = std::vector<std::uint8_t>;

namespace {

const Key kKey = Key::from_text("000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f").value();
const Packet kMessage{1, 2, 3, 4, 5, 6, 7};
constexpr const char* kChannel = "STROBE/bench/SHOT";

}  // namespace

TEST_GROUP(PacketSeal) {
  PacketSeal seal{kKey};
  Packet packet = seal.seal(kChannel, kMessage, {0x1122334455667788, 9});

  /// "opened", or why not.
  static std::string answer(const Packet& bytes, const PacketSeal& by = PacketSeal(kKey),
                            const char* channel = kChannel) {
    const auto opened = by.open(channel, bytes);
    if (!opened) return name(opened.error());
    return std::ranges::equal(opened->message, kMessage) ? "opened" : "another message";
  }
};

TEST(PacketSeal, IsOpenedByTheSameKeyOnTheSameChannelAndTellsItsNumber) {
  CHECK_EQUAL("opened", answer(packet));
  CHECK_EQUAL(std::int64_t{0x1122334455667788}, seal.open(kChannel, packet)->number.sender);
  CHECK_EQUAL(std::int64_t{9}, seal.open(kChannel, packet)->number.sequence);
}

TEST(PacketSeal, IsTheKeyedHashThatItsHeaderNames) {
  // By another implementation, Python's: message = bytes(range(1, 8)); key = bytes(range(32));
  // number = bytes.fromhex("1122334455667788") + (9).to_bytes(8, "big"); channel = b"STROBE/bench/SHOT";
  // blake2b(number + (17).to_bytes(2, "big") + channel + message, key=key, digest_size=16,
  // person=b"strobe.packet..1").
  std::string digits;
  for (std::size_t i = packet.size() - 16; i < packet.size(); ++i) {
    constexpr const char* kDigits = "0123456789abcdef";
    digits += kDigits[packet[i] >> 4];
    digits += kDigits[packet[i] & 15];
  }
  CHECK_EQUAL("340cc9624a07fa5d45cb9215a4f2d7ff", digits);
  LONGS_EQUAL(kMessage.size() + 44, packet.size());
}

TEST(PacketSeal, StandsBehindAMessageThatLcmsOwnDecoderStillReads) {
  strobe_msgs::event_t event{};
  event.schema_version = strobe_msgs::event_t::SCHEMA_VERSION;
  event.boot_id = 77;
  event.detail = "some words";
  const Packet bytes = strobe::messages::encode(event);
  const Packet sealed = seal.seal("STROBE/bench/EVENT", bytes, {1, 1});
  strobe_msgs::event_t read{};
  LONGS_EQUAL(bytes.size(), read.decode(sealed.data(), 0, static_cast<int>(sealed.size())));
  CHECK_EQUAL(std::int64_t{77}, read.boot_id);
  CHECK_EQUAL("some words", read.detail);
  CHECK_TRUE(std::ranges::equal(message_of(sealed), bytes));
  CHECK_TRUE(std::ranges::equal(message_of(bytes), bytes));
}

TEST(PacketSeal, IsNotOpenedByAnotherKeyNorWhereTheFingerprintIsMadeToFit) {
  const Packet others = PacketSeal(Key::random()).seal(kChannel, kMessage, {1, 1});
  CHECK_EQUAL("other_key", answer(others));
  Packet pretended = others;
  std::copy_n(packet.begin() + 7 + 8, 4, pretended.begin() + 7 + 8);
  CHECK_EQUAL("altered", answer(pretended));
}

TEST(PacketSeal, IsOfOneChannelOfOneRig) {
  for (const char* channel : {"STROBE/bench/EVENT", "STROBE/benc/SHOT", "STROBE/bench2/SHOT",
                              "STROBE/bench/SHO", "STROBE/bench/SHOTS", ""})
    CHECK_EQUAL("altered", answer(packet, seal, channel));
}

TEST(PacketSeal, DoesNotLetBytesMoveBetweenChannelAndMessage) {
  // What is hashed is the same but for the size.
  const Packet moved =
      seal.seal("STROBE/bench/SHO", Packet{'T', 1, 2, 3, 4, 5, 6, 7}, {0x1122334455667788, 9});
  Packet pieced = packet;
  std::copy(moved.end() - 16, moved.end(), pieced.end() - 16);
  CHECK_EQUAL("altered", answer(pieced));
}

TEST(PacketSeal, IsBrokenByEveryChangeOfOneBit) {
  for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
    Packet altered = packet;
    altered[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    const std::size_t at = bit / 8;
    // Mark and fingerprint are looked at before the proof.
    const char* expected = at >= 7 && at < 15 ? "unsealed" : at >= 15 && at < 19 ? "other_key" : "altered";
    CHECK_EQUAL(expected, answer(altered));
  }
}

TEST(PacketSeal, IsBrokenByEveryCutAndEveryAddition) {
  for (std::size_t size = 0; size < packet.size(); ++size)
    CHECK_EQUAL("unsealed",
                answer(Packet(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(size))));
  for (std::size_t cut = 1; cut <= kMessage.size(); ++cut)
    CHECK_EQUAL("altered", answer(Packet(packet.begin() + static_cast<std::ptrdiff_t>(cut), packet.end())));
  packet.push_back(0);
  CHECK_EQUAL("unsealed", answer(packet));
}

TEST(PacketSeal, HoldsAMessageOfAnySize) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{200'000}}) {
    const Packet message(size, 7);
    const Packet sealed = seal.seal(kChannel, message, {-5, 1});
    const auto opened = seal.open(kChannel, sealed);
    CHECK_TRUE(opened && std::ranges::equal(opened->message, message));
    CHECK_EQUAL(std::int64_t{-5}, opened->number.sender);
  }
}

TEST(PacketSeal, LooksAtNothingBeyondTheBytes) {
  const unsigned seed = std::random_device{}();
  std::mt19937 random(seed);
  for (int trial = 0; trial < 20'000; ++trial) {
    Packet bytes = packet;
    bytes.resize(random() % (2 * packet.size()));
    for (std::size_t k = random() % 4; k > 0 && !bytes.empty(); --k)
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (bytes != packet) CHECK_TEXT(!seal.open(kChannel, bytes), std::to_string(seed).c_str());
  }
}
