#include "firmware/publisher/resend_queue.hpp"

#include <string>

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

TEST_GROUP(ResendQueue) {
  static constexpr std::int64_t kThis = 1, kEarlier = 2;
  ResendQueue queue;

  bool ask(std::int64_t host, std::int64_t boot, std::int64_t first, std::int64_t last) {
    return queue.add({host, {boot, {first, last}}, boot == kThis});
  }
  std::string next() {
    const auto range = queue.next();
    if (!range) return "none";
    return std::to_string(range->boot_id) + ": " + std::to_string(range->sequences.first) + " to " +
           std::to_string(range->sequences.last);
  }
};

TEST(ResendQueue, ServesHostsInTurnAndThisBootFirst) {
  for (std::int64_t k = 0; k < 3; ++k) CHECK_TRUE(ask(7, kEarlier, 10 * k + 1, 10 * k + 5));
  CHECK_TRUE(ask(8, kEarlier, 100, 200));
  CHECK_TRUE(ask(7, kThis, 1, 2));
  CHECK_EQUAL("1: 1 to 2", next());
  CHECK_EQUAL("2: 100 to 200", next());
  CHECK_EQUAL("2: 1 to 5", next());
  CHECK_EQUAL("2: 11 to 15", next());
  CHECK_FALSE(queue.empty());
  CHECK_EQUAL("2: 21 to 25", next());
  CHECK_TRUE(queue.empty());
  CHECK_EQUAL("none", next());
}

TEST(ResendQueue, EntersOnceWhatSeveralHostsAskForAgainAndAgain) {
  for (int times = 0; times < 3; ++times) {
    CHECK_TRUE(ask(7, kThis, 1, 100));
    CHECK_TRUE(ask(8, kThis, 1, 100));
    CHECK_TRUE(ask(8, kThis, 50, 60));
  }
  CHECK_EQUAL("1: 1 to 100", next());
  CHECK_TRUE(ask(8, kThis, 50, 60));  // is being answered
  CHECK_TRUE(queue.empty());
  CHECK_TRUE(ask(8, kThis, 50, 101));
  CHECK_EQUAL("1: 50 to 101", next());
  CHECK_EQUAL("none", next());
  CHECK_TRUE(ask(8, kThis, 50, 101));  // that answer is over
  CHECK_EQUAL("1: 50 to 101", next());
}

TEST(ResendQueue, BoundsWhatAHostAsksFor) {
  CHECK_TRUE(ask(7, kThis, -5, INT64_MAX));
  CHECK_EQUAL("1: 1 to 4096", next());
  CHECK_TRUE(ask(7, kThis, INT64_MAX - 1, INT64_MAX));
  CHECK_EQUAL("1: 9223372036854775806 to 9223372036854775807", next());
  CHECK_FALSE(ask(7, kThis, 6, 5));
  CHECK_FALSE(ask(7, kThis, INT64_MAX, INT64_MIN));
  CHECK_EQUAL("none", next());
}

TEST(ResendQueue, LetsNoHostTakeTheOthersPlaces) {
  std::int64_t entered = 0;
  for (std::int64_t host = 1; host <= 1000; ++host) {
    for (std::int64_t k = 1; k <= 100; ++k) {
      entered += ask(host, kThis, 1000 * host + k, 1000 * host + k) ? 1 : 0;
      entered += ask(host, kEarlier, 1000 * host + k, 1000 * host + k) ? 1 : 0;
    }
  }
  CHECK_EQUAL(static_cast<std::int64_t>(ResendQueue::kMaxHosts * 2 * ResendQueue::kMaxOfHost), entered);
  for (std::int64_t host = 1; host <= 16; ++host) {
    const std::string first = std::to_string(1000 * host + 1);
    CHECK_EQUAL("1: " + first + " to " + first, next());
  }
}
