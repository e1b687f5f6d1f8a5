#include "common/flash_sequencer/protocol.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::flash_sequencer;

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes wire_of(const Frame& frame) {
  std::array<std::uint8_t, kMaxFrame> wire;
  const std::size_t size = encode(frame, wire);
  return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(size)};
}

std::vector<Frame> decoded(Decoder& decoder, const Bytes& wire) {
  std::vector<Frame> frames;
  for (const std::uint8_t byte : wire)
    if (const Frame* frame = decoder.take(byte)) frames.push_back(*frame);
  return frames;
}

bool same(const Frame& one, const Frame& other) {
  return one.kind == other.kind && one.number == other.number && std::ranges::equal(one.bytes(), other.bytes());
}

Frame drawn_frame(std::mt19937& random) {
  Frame frame;
  frame.kind = static_cast<std::uint8_t>(random());
  frame.number = static_cast<std::uint8_t>(random());
  frame.size = static_cast<std::uint8_t>(random() % (kMaxBody + 1));
  const bool mostly_zeroes = random() % 2 == 0;
  for (std::size_t i = 0; i < frame.size; ++i)
    frame.body[i] = mostly_zeroes && random() % 4 != 0 ? 0 : static_cast<std::uint8_t>(random());
  return frame;
}

template <typename T>
T drawn_of(std::mt19937_64& random) {
  return static_cast<T>(random());
}

/// The bytes of both are the same: what was read is what was written.
template <typename Value, typename Read>
void check_round_trip(const Value& value, Read read) {
  const Frame frame = to_frame(value);
  const auto back = read(frame);
  CHECK(back.has_value());
  CHECK(same(frame, to_frame(*back)));
  Frame shorter = frame;
  --shorter.size;
  CHECK_FALSE(read(shorter).has_value());
  Frame longer = frame;
  ++longer.size;
  CHECK_FALSE(read(longer).has_value());
  Frame other = frame;
  other.kind ^= 0x40;
  CHECK_FALSE(read(other).has_value());
}

}  // namespace

TEST_GROUP(SequencerFrames) {
  Decoder decoder;
};

TEST(SequencerFrames, TheCrcIsThatOfEthernet) {
  const Bytes digits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  CHECK_EQUAL(0xCBF43926U, crc32(digits));  // the catalogues' check value
  CHECK_EQUAL(0xCBF43926U, crc32(std::span(digits).subspan(4), crc32(std::span(digits).first(4))));
  CHECK_EQUAL(0U, crc32({}));
}

// By hand, after the figures of Cheshire and Baker: a code byte counts itself and what follows up to a zero.
TEST(SequencerFrames, ZeroesAreStuffedAsThePaperSays) {
  Frame frame;
  frame.kind = 0x11;
  frame.number = 0;
  frame.size = 3;
  frame.body = {0, 0x22, 0};
  const std::uint32_t crc = crc32(Bytes{0x11, 0, 0, 0x22, 0});
  Bytes expected{2, 0x11, 1, 2, 0x22};
  Bytes block;
  for (int i = 0; i < 4; ++i) {
    const auto byte = static_cast<std::uint8_t>(crc >> (8 * i));
    CHECK(byte != 0);
    block.push_back(byte);
  }
  expected.push_back(5);
  expected.insert(expected.end(), block.begin(), block.end());
  expected.push_back(0);
  CHECK(expected == wire_of(frame));
}

TEST(SequencerFrames, ComeBackAsTheyWereSentAndOnTheWireHaveOneZero) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const Frame frame = drawn_frame(random);
    const Bytes wire = wire_of(frame);
    CHECK_EQUAL(frame.size + std::size_t{8}, wire.size());
    CHECK_EQUAL(wire.end() - 1, std::ranges::find(wire, 0));
    const auto back = decoded(decoder, wire);
    CHECK_EQUAL(std::size_t{1}, back.size());
    CHECK(same(frame, back[0]));
  }
  CHECK_EQUAL(0U, decoder.damaged());
}

// CRC-32 finds all bursts up to 32 bits; a byte on the wire changed to or from a zero joins or parts frames, which
// leaves a wrong CRC but for one in 2^32.
TEST(SequencerFrames, OneDamagedByteIsFoundAndTheNextFrameIsWhole) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    const Frame frame = drawn_frame(random), next = drawn_frame(random);
    Bytes wire = wire_of(frame);
    wire[random() % wire.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    if (wire.back() != 0) wire.push_back(0);  // else the next frame is lost with this one
    CHECK(decoded(decoder, wire).empty());
    const auto after = decoded(decoder, wire_of(next));
    CHECK_EQUAL(std::size_t{1}, after.size());
    CHECK(same(next, after[0]));
  }
  CHECK(decoder.damaged() >= 2000);
}

TEST(SequencerFrames, AnyBytesAreTakenAndZeroesAreNoFrames) {
  std::mt19937 random(3);
  CHECK(decoded(decoder, Bytes(1000, 0)).empty());
  CHECK_EQUAL(0U, decoder.damaged());
  CHECK(decoded(decoder, Bytes(100'000, 7)).empty());
  CHECK(decoded(decoder, Bytes(1, 0)).empty());
  CHECK_EQUAL(1U, decoder.damaged());
  Bytes noise(100'000);
  for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
  CHECK(decoded(decoder, noise).empty());
  decoder.take(0);
  CHECK_EQUAL(std::size_t{1}, decoded(decoder, wire_of(drawn_frame(random))).size());
}

TEST_GROUP(SequencerBodies) {
  std::mt19937_64 random{4};
};

TEST(SequencerBodies, ComeBackAsTheyWereSent) {
  for (int i = 0; i < 200; ++i) {
    Limits limits;
    for (auto& max_on_us : limits.max_on_us) max_on_us = drawn_of<std::uint32_t>(random);
    check_round_trip(limits, read_limits);
    check_round_trip(Arm{{drawn_of<std::uint16_t>(random), 3}, drawn_of<std::uint32_t>(random), 1}, read_arm);
    check_round_trip(Start{drawn_of<std::uint32_t>(random), drawn_of<Ticks>(random), drawn_of<Ticks>(random),
                           drawn_of<Ticks>(random)},
                     read_start);
    check_round_trip(Identity{kVersion, random(), 1, kMaxEdges}, read_identity);
    check_round_trip(InputEdge{drawn_of<std::uint16_t>(random), InputLine::xsync, 1, drawn_of<Ticks>(random)}, read_input);
    Status status;
    status.answers = Request::start;
    status.refusal = Refusal::too_late;
    status.phase = Phase::playing;
    status.cut = CutCause::overrun;
    status.challenge = drawn_of<std::uint32_t>(random);
    status.received = drawn_of<Ticks>(random);
    status.played = {drawn_of<std::uint16_t>(random), drawn_of<std::uint16_t>(random)};
    check_round_trip(status, read_status);
    CHECK_EQUAL(kNoTicks, read_status(to_frame(status))->started);
  }
}

TEST(SequencerBodies, ALoadHasWholeEdges) {
  Load load;
  load.track = Track::lamps;
  load.first = 0x1234;
  for (load.count = 0; load.count < Load::kMaxEdges; ++load.count)
    load.edges[load.count] = {drawn_of<std::uint32_t>(random), drawn_of<std::uint32_t>(random)};
  check_round_trip(load, read_load);
  load.count = 0;
  check_round_trip(load, read_load);
}

TEST(SequencerBodies, NumbersAreLittleEndian) {
  const Frame frame = to_frame(Start{0x01020304, -2, 0x1122334455667788, 0});
  const Bytes begin(frame.body.begin(), frame.body.begin() + 20);
  CHECK((begin == Bytes{4, 3, 2, 1, 0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11}));
}

TEST(SequencerBodies, ValuesThatNothingStandsForAreRefused) {
  Frame status = to_frame(Status{});
  for (const std::size_t field : {0U, 1U, 2U, 3U}) {
    Frame wrong = status;
    wrong.body[field] = 99;
    CHECK_FALSE(read_status(wrong).has_value());
  }
  status.body[0] = 0;  // no request has this number
  CHECK_FALSE(read_status(status).has_value());
  Frame load = to_frame(Load{});
  load.body[0] = 2;
  CHECK_FALSE(read_load(load).has_value());
}

TEST(SequencerBodies, ATrainsCrcIsThatOfItsEdgesAsTheyAreCarried) {
  const std::array movers{Edge{1, 2}}, lamps{Edge{0x01020304, 5}};
  CHECK_EQUAL(crc32(Bytes{1, 0, 0, 0, 2, 0, 0, 0, 4, 3, 2, 1, 5, 0, 0, 0}), train_crc(movers, lamps));
}
