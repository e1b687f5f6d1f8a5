// Bytes from the network: whatever they are, nothing is thrown and nothing but this rig's messages gets
// through.
#include "host/messages/message_decoder.hpp"

#include <limits>
#include <stdexcept>
#include <string>
#include <strobe_msgs/readout_t.hpp>
#include <utility>
#include <vector>

#include "common/messages/well_formed.hpp"
#include "tests/host/synthetic_shot.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using strobe::host::MessageDecoder;
using strobe::host::MessageHandler;

struct CountingSink : MessageHandler {
  int statuses = 0, events = 0, shots = 0, frames = 0;
  std::int64_t last_ns = 0;
  bool throws = false;

  void status(const strobe_msgs::status_t&, std::int64_t now_ns) override {
    ++statuses;
    last_ns = now_ns;
    if (throws) throw std::runtime_error("the disk is full");
  }
  void event(const strobe_msgs::event_t&, std::int64_t) override { ++events; }
  void shot(const strobe_msgs::shot_t&, std::int64_t) override { ++shots; }
  void frame(const strobe_msgs::frame_t&, std::int64_t) override { ++frames; }
};

template <typename Message>
std::vector<char> bytes_of(const Message& message) {
  std::vector<char> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

strobe_msgs::status_t status() {
  strobe_msgs::status_t message{};
  message.schema_version = strobe_msgs::status_t::SCHEMA_VERSION;
  message.wall_ns = 1'800'000'000'000'000'000;  // in 2027
  message.histograms.resize(2), message.histogram_count = 2;
  for (auto& histogram : message.histograms) histogram.quantity = 1, histogram.bin_width_us = 1.0;
  message.histograms[0].bins = {1, 2, 3}, message.histograms[0].bin_count = 3;
  return message;
}

}  // namespace

TEST_GROUP(DecodingOfMessages) {
  CountingSink sink;
  MessageDecoder decoder{"bench", sink};

  void give(const std::string& channel, const std::vector<char>& bytes) {
    decoder.receive(channel, bytes.data(), bytes.size(), 42);
  }
};

TEST(DecodingOfMessages, EachChannelHasItsType) {
  const auto made = strobe::host_test::make_shot({});
  give("STROBE/bench/STATUS", bytes_of(status()));
  give("STROBE/bench/SHOT", bytes_of(made.shot));
  give("STROBE/bench/FRAME", bytes_of(made.frame));
  LONGS_EQUAL(1, sink.statuses);
  LONGS_EQUAL(1, sink.shots);
  LONGS_EQUAL(1, sink.frames);
  LONGS_EQUAL(42, sink.last_ns);
  LONGS_EQUAL(0, decoder.undecodable());
}

TEST(DecodingOfMessages, AnEventWhoseTextClaimsALengthBelowOneIsCountedAndHarmless) {
  strobe_msgs::event_t event{};
  event.schema_version = strobe_msgs::event_t::SCHEMA_VERSION;
  give("STROBE/bench/EVENT", bytes_of(event));
  LONGS_EQUAL(1, sink.events);
  // The text is the last field: its length, then the zero that ends it.
  for (const std::uint32_t length : {0U, 0xffffffffU, 0x80000000U}) {
    auto hostile = bytes_of(event);
    for (std::size_t i = 0; i < 4; ++i)
      hostile[hostile.size() - 5 + i] = static_cast<char>(length >> (24 - 8 * i));
    give("STROBE/bench/EVENT", hostile);
  }
  LONGS_EQUAL(1, sink.events);
  LONGS_EQUAL(3, decoder.undecodable());
  STRCMP_EQUAL("", decoder.fault().c_str());
}

TEST(DecodingOfMessages, NumbersThatCannotBeReckonedWithAreLeft) {
  auto made = strobe::host_test::make_shot({});
  made.shot.flashes[1].flash_index = 1'000'000;
  give("STROBE/bench/SHOT", bytes_of(made.shot));
  made.shot.flashes[1].flash_index = 1;
  made.shot.flashes[1].observed_a_ns = std::numeric_limits<std::int64_t>::max();
  give("STROBE/bench/SHOT", bytes_of(made.shot));
  auto far = status();
  far.last_sequence = std::numeric_limits<std::int64_t>::max();
  give("STROBE/bench/STATUS", bytes_of(far));
  LONGS_EQUAL(0, sink.shots);
  LONGS_EQUAL(0, sink.statuses);
  LONGS_EQUAL(3, decoder.undecodable());
}

TEST(DecodingOfMessages, AReadoutTellsItsHostWithoutBeingDecoded) {
  strobe_msgs::readout_t readout{};
  readout.host_id = -0x0123456789abcdef;
  const std::vector<char> bytes = bytes_of(readout);
  LONGLONGS_EQUAL(readout.host_id, strobe::messages::readout_host(bytes.data(), bytes.size()));
  const std::vector<char> other = bytes_of(status());
  LONGLONGS_EQUAL(0, strobe::messages::readout_host(other.data(), other.size()));
  for (std::size_t size = 0; size < 20; ++size)
    LONGLONGS_EQUAL(0, strobe::messages::readout_host(bytes.data(), size));
}

TEST(DecodingOfMessages, OtherRigsAndTypesAreLeft) {
  give("STROBE/other/STATUS", bytes_of(status()));
  give("STROBE/bench/READOUT", bytes_of(status()));
  LONGS_EQUAL(0, sink.statuses);
  give("STROBE/bench/SHOT", bytes_of(status()));
  LONGS_EQUAL(0, sink.shots);
  LONGS_EQUAL(1, decoder.undecodable());
  auto future = status();
  future.schema_version = 99;
  give("STROBE/bench/STATUS", bytes_of(future));
  LONGS_EQUAL(0, sink.statuses);
}

TEST(DecodingOfMessages, WhatTheSinkThrowsEndsHere) {
  sink.throws = true;
  give("STROBE/bench/STATUS", bytes_of(status()));
  STRCMP_EQUAL("the disk is full", decoder.fault().c_str());
}

TEST(DecodingOfMessages, CutBytesAreNoMessage) {
  const auto made = strobe::host_test::make_shot({});
  for (const auto& [channel, whole] : {std::pair{"STROBE/bench/FRAME", bytes_of(made.frame)},
                                       std::pair{"STROBE/bench/SHOT", bytes_of(made.shot)},
                                       std::pair{"STROBE/bench/STATUS", bytes_of(status())}}) {
    for (std::size_t length = 0; length < whole.size(); ++length) {
      give(channel, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)});
    }
  }
  LONGS_EQUAL(0, sink.frames + sink.shots + sink.statuses);
}

TEST(DecodingOfMessages, ACountThatTheBytesCannotHoldIsRefusedBeforeRoomIsMadeForIt) {
  const auto made = strobe::host_test::make_shot({});
  int refused = 0;
  for (const auto& [channel, whole] : {std::pair{"STROBE/bench/FRAME", bytes_of(made.frame)},
                                       std::pair{"STROBE/bench/SHOT", bytes_of(made.shot)},
                                       std::pair{"STROBE/bench/STATUS", bytes_of(status())}}) {
    // Wherever a count is, it is claimed to be 1.9e9 (its first byte 0x70) and -1.9e9.
    for (std::size_t at = 8; at < whole.size(); ++at) {
      for (const char byte : {'\x70', '\x90'}) {
        auto changed = whole;
        changed[at] = byte;
        give(channel, changed);
      }
    }
    refused += static_cast<int>(decoder.undecodable());
  }
  CHECK_TRUE(refused > 0);
}
