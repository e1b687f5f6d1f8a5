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

#include "tests/support/string_from.hpp"

namespace {

using strobe::host::MessageDecoder;
using strobe::host::MessageHandler;
using strobe::messages::encode;

struct CountingHandler : MessageHandler {
  int statuses = 0, events = 0, shots = 0, frames = 0;
  bool throws = false;

  void on_status(const strobe_msgs::status_t&) override {
    ++statuses;
    if (throws) throw std::runtime_error("the disk is full");
  }
  void on_event(const strobe_msgs::event_t&) override { ++events; }
  void on_shot(const strobe_msgs::shot_t&) override { ++shots; }
  void on_frame(const strobe_msgs::frame_t&) override { ++frames; }
};

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
  CountingHandler handler;
  MessageDecoder decoder{"bench", handler};

  void give(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
    decoder.receive(channel, bytes);
  }
};

TEST(DecodingOfMessages, EachChannelHasItsType) {
  const auto made = strobe::host_test::make_shot({});
  give("STROBE/bench/STATUS", encode(status()));
  give("STROBE/bench/SHOT", encode(made.shot));
  give("STROBE/bench/FRAME", encode(made.frame));
  LONGS_EQUAL(1, handler.statuses);
  LONGS_EQUAL(1, handler.shots);
  LONGS_EQUAL(1, handler.frames);
  LONGS_EQUAL(0, decoder.undecodable());
}

TEST(DecodingOfMessages, AnEventWhoseTextClaimsALengthBelowOneIsCountedAndHarmless) {
  strobe_msgs::event_t event{};
  event.schema_version = strobe_msgs::event_t::SCHEMA_VERSION;
  give("STROBE/bench/EVENT", encode(event));
  LONGS_EQUAL(1, handler.events);
  // The text is the last field: its length, then the zero that ends it.
  for (const std::uint32_t length : {0U, 0xffffffffU, 0x80000000U}) {
    auto hostile = encode(event);
    for (std::size_t i = 0; i < 4; ++i)
      hostile[hostile.size() - 5 + i] = static_cast<std::uint8_t>(length >> (24 - 8 * i));
    give("STROBE/bench/EVENT", hostile);
  }
  LONGS_EQUAL(1, handler.events);
  LONGS_EQUAL(3, decoder.undecodable());
  CHECK_EQUAL("", decoder.fault());
}

TEST(DecodingOfMessages, NumbersOutOfRangeAreIgnored) {
  auto made = strobe::host_test::make_shot({});
  made.shot.flashes[1].flash_index = 1'000'000;
  give("STROBE/bench/SHOT", encode(made.shot));
  made.shot.flashes[1].flash_index = 1;
  made.shot.flashes[1].observed_a_ns = std::numeric_limits<std::int64_t>::max();
  give("STROBE/bench/SHOT", encode(made.shot));
  auto far = status();
  far.last_sequence = std::numeric_limits<std::int64_t>::max();
  give("STROBE/bench/STATUS", encode(far));
  LONGS_EQUAL(0, handler.shots);
  LONGS_EQUAL(0, handler.statuses);
  LONGS_EQUAL(3, decoder.undecodable());
}

TEST(DecodingOfMessages, OtherRigsAndTypesAreIgnored) {
  give("STROBE/other/STATUS", encode(status()));
  give("STROBE/bench/READOUT", encode(status()));
  LONGS_EQUAL(0, handler.statuses);
  give("STROBE/bench/SHOT", encode(status()));
  LONGS_EQUAL(0, handler.shots);
  LONGS_EQUAL(1, decoder.undecodable());
  auto future = status();
  future.schema_version = 99;
  give("STROBE/bench/STATUS", encode(future));
  LONGS_EQUAL(0, handler.statuses);
}

TEST(DecodingOfMessages, WhatTheHandlerThrowsEndsHere) {
  handler.throws = true;
  give("STROBE/bench/STATUS", encode(status()));
  CHECK_EQUAL("the disk is full", decoder.fault());
}

TEST(DecodingOfMessages, CutBytesAreNoMessage) {
  const auto made = strobe::host_test::make_shot({});
  for (const auto& [channel, whole] : {std::pair{"STROBE/bench/FRAME", encode(made.frame)},
                                       std::pair{"STROBE/bench/SHOT", encode(made.shot)},
                                       std::pair{"STROBE/bench/STATUS", encode(status())}})
    for (std::size_t length = 0; length < whole.size(); ++length)
      give(channel, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)});
  LONGS_EQUAL(0, handler.frames + handler.shots + handler.statuses);
}

TEST(DecodingOfMessages, ACountThatTheBytesCannotHoldIsRefusedBeforeRoomIsMadeForIt) {
  const auto made = strobe::host_test::make_shot({});
  int refused = 0;
  for (const auto& [channel, whole] : {std::pair{"STROBE/bench/FRAME", encode(made.frame)},
                                       std::pair{"STROBE/bench/SHOT", encode(made.shot)},
                                       std::pair{"STROBE/bench/STATUS", encode(status())}}) {
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
