#include "tests/support/host_bench.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using strobe::testing::ManualClock;
using strobe::testing::RememberingBus;

TEST_GROUP(HostBench){};

TEST(HostBench, ClockStandsUntilItIsMoved) {
  ManualClock clock;
  const auto before = clock.read();
  CHECK(clock.read().mono == before.mono);
  clock.now += milliseconds{5};
  CHECK(clock.read().mono == before.mono + milliseconds{5});
  CHECK(clock.read().wall == before.wall + milliseconds{5});
  clock.wall_ahead = milliseconds{7};
  CHECK(clock.read().mono == before.mono + milliseconds{5});
  CHECK(clock.read().wall == before.wall + milliseconds{12});
}

TEST(HostBench, BusBringsAPacketOnceAndRemembersWhatWasSentOnAChannel) {
  RememberingBus bus;
  bus.arriving = {{"bench/A", {1, 2}}, {"bench/B", {3}}};
  std::vector<std::string> heard;
  const auto hear = [&](const std::string& channel, auto) { heard.push_back(channel); };
  CHECK(bus.receive(milliseconds{1}, {}, hear));
  CHECK(bus.receive(milliseconds{1}, {}, hear));
  LONGS_EQUAL(2, heard.size());
  const std::vector<std::uint8_t> bytes{4, 5};
  bus.publish("bench/A", bytes);
  bus.publish("bench/B", bytes);
  CHECK(bus.sent_on("bench/A") == std::vector<std::vector<std::uint8_t>>{bytes});
  LONGS_EQUAL(2, bus.sent.size());
  bus.failed = true;
  CHECK(!bus.receive(milliseconds{1}, {}, hear));
}
