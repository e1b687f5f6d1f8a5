#include "tests/soak/bus.hpp"

#include <map>
#include <vector>

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::soak;

TEST_GROUP(VirtualBus) {
  VirtualBus bus{7};

  /// Sends packets 0, 1, 2 ... one a millisecond; gives their numbers in order of arrival.
  std::vector<int> arrivals(int count, Receiver to = Receiver::host) {
    for (int i = 0; i < count; ++i) {
      const std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i)};
      bus.send(to, "channel", bytes, from_ns(std::int64_t{i} * 1'000'000));
    }
    std::vector<int> numbers;
    MonoTime last{};
    while (bus.next_due() != kFarFuture) {
      const auto delivery = bus.take();
      CHECK(delivery.at >= last);
      last = delivery.at;
      numbers.push_back(delivery.packet->bytes[0] << 8 | delivery.packet->bytes[1]);
      CHECK(delivery.at > from_ns(std::int64_t{numbers.back()} * 1'000'000));
      bus.done(delivery);
    }
    return numbers;
  }
};

TEST(VirtualBus, DeliversEachPacketOnceAndInOrderWithoutFaults) {
  const auto numbers = arrivals(3000);
  LONGS_EQUAL(3000, numbers.size());
  for (int i = 0; i < 3000; ++i) LONGS_EQUAL(i, numbers[static_cast<std::size_t>(i)]);
}

TEST(VirtualBus, KeepsItsOrderEvenIfPacketsAreSentAtOneInstant) {
  for (std::uint8_t i = 0; i < 200; ++i) bus.send(Receiver::host, "c", std::vector{i}, from_ns(5));
  for (std::uint8_t i = 0; i < 200; ++i) {
    const auto delivery = bus.take();
    LONGS_EQUAL(i, delivery.packet->bytes[0]);
    bus.done(delivery);
  }
}

TEST(VirtualBus, LosesTheStatedShareOfPackets) {
  bus.set_faults({.loss = 0.2});
  const auto numbers = arrivals(20'000);
  // 4000 lost with a sd of 57.
  CHECK(std::abs(static_cast<double>(bus.counts().lost) - 4000.0) < 5.0 * 57.0);
  LONGS_EQUAL(20'000 - bus.counts().lost, static_cast<std::int64_t>(numbers.size()));
}

TEST(VirtualBus, DoublesPackets) {
  bus.set_faults({.duplication = 0.1});
  std::map<int, int> times;
  for (const int number : arrivals(10'000)) ++times[number];
  std::int64_t doubled = 0;
  for (const auto& [number, count] : times) doubled += count == 2 ? 1 : 0;
  LONGS_EQUAL(10'000, times.size());
  LONGS_EQUAL(bus.counts().doubled, doubled);
  CHECK(doubled > 800 && doubled < 1200);  // sd 30
}

TEST(VirtualBus, LetsPacketsOvertakeEachOther) {
  bus.set_faults({.reordering = 0.1});
  const auto numbers = arrivals(5'000);
  LONGS_EQUAL(5'000, numbers.size());
  int overtaken = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) overtaken += numbers[i] < numbers[i - 1] ? 1 : 0;
  CHECK(overtaken > 300);
}

TEST(VirtualBus, RepeatsItselfFromItsSeed) {
  const BusFaults faults{0.2, 0.1, 0.1};
  bus.set_faults(faults);
  const auto first = arrivals(2'000);
  bus = VirtualBus(7);
  bus.set_faults(faults);
  CHECK_EQUAL(arrivals(2'000), first);
  bus = VirtualBus(8);
  bus.set_faults(faults);
  CHECK(first != arrivals(2'000));
}
