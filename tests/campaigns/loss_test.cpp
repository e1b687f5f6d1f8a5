#include <chrono>
#include <lcm/lcm-cpp.hpp>
#include <string>

#include "tests/campaigns/drawn_trials.hpp"
#include "tests/campaigns/loss.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/process.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::loss;
using namespace std::chrono_literals;
using strobe::testing::private_lcm_url;

namespace {

/// A network and how much was heard on it.
struct Network {
  std::string url = private_lcm_url();
  lcm::LCM lcm{url};
  std::int64_t heard = 0;

  Network() { lcm.subscribe("X", &Network::hear, this)->setQueueCapacity(10'000); }
  void hear(const lcm::ReceiveBuffer*, const std::string&) { ++heard; }
  void send(int count) {
    for (int i = 0; i < count; ++i) lcm.publish("X", "message", 7);
  }
};

struct Networks {
  Network a, b;

  template <typename Condition>
  void receive(std::chrono::milliseconds limit, const Condition& done) {
    const std::int64_t end = strobe::testing::monotonic_now_ns() + std::chrono::nanoseconds(limit).count();
    while (!done() && strobe::testing::monotonic_now_ns() < end) {
      a.lcm.handleTimeout(1);
      b.lcm.handleTimeout(1);
    }
  }
  /// Until that much was heard, or the limit has passed, which no busy machine needs; then a little longer, for what
  /// should not come.
  void expect(std::int64_t at_a, std::int64_t at_b) {
    receive(10s, [&] { return a.heard >= at_a && b.heard >= at_b; });
    receive(50ms, [] { return false; });
    LONGS_EQUAL(at_a, a.heard);
    LONGS_EQUAL(at_b, b.heard);
  }
};

std::map<std::string, double> expect_nothing_lost(const Trial& trial) {
  strobe::campaigns::Draws draws(1, 1);
  const auto verdict = run_trial(trial, draws);
  strobe::campaigns::expect_nothing_violated(verdict);
  LONGS_EQUAL(0, verdict.counts.at("missing events"));
  LONGS_EQUAL(trial.kills, verdict.counts.at("kills"));
  return verdict.counts;
}

}  // namespace

TEST_GROUP(LossyLink){};

TEST(LossyLink, CarriesEverythingBothWaysOnce) {
  Networks networks;
  const LossyLink relay(networks.a.url, networks.b.url, {}, 1);
  networks.a.send(200);
  networks.expect(200, 200);  // its own network's, and no echo
  networks.b.send(100);
  networks.expect(300, 300);
  LONGS_EQUAL(300, relay.counts().came);
}

TEST(LossyLink, LosesDoublesAndDelaysAsOftenAsItIsTold) {
  Networks networks;
  const LossyLink relay(networks.a.url, networks.b.url, {0.5, 0.25, 0.25, 20}, 1);
  networks.a.send(1000);
  networks.receive(10s, [&] { return relay.counts().came == 1000; });
  const LinkCounts counts = relay.counts();
  networks.expect(1000, 1000 - counts.lost + counts.doubled);
  LONGS_EQUAL(1000, counts.came);
  // Four standard deviations of a count of 1000 at one half, and of 500 at a quarter (once more delayed).
  CHECK(counts.lost > 437 && counts.lost < 563);
  CHECK(counts.doubled > 80 && counts.doubled < 170);
  CHECK(counts.delayed > 100 && counts.delayed < 215);
}

TEST(LossyLink, CarriesNothingWhileItIsCut) {
  Networks networks;
  LossyLink relay(networks.a.url, networks.b.url, {}, 1);
  relay.cut(true);
  networks.a.send(10);
  networks.receive(10s, [&] { return relay.counts().cut == 10; });
  networks.expect(10, 0);
  LONGS_EQUAL(10, relay.counts().cut);
  relay.cut(false);
  networks.a.send(10);
  networks.expect(20, 10);
}

// The shipped programs across a link that loses, and killed in the middle of shots. Nothing here judges time.

TEST_GROUP(Loss){};

TEST(Loss, OfAFifthWithDoublesAndLatecomersLeavesNothingMissingInTheEnd) {
  const auto counts = expect_nothing_lost({"", Victim::nobody, {0.2, 0.1, 0.2, 60}});
  CHECK(counts.at("packets lost") > 10 && counts.at("packets doubled") > 5 &&
        counts.at("packets delayed") > 10);
}

TEST(Loss, OfTheWholeLinkForAWhileInTheMiddleOfAShotLeavesNothingMissingInTheEnd) {
  CHECK(expect_nothing_lost({.cut_s = 1.5}).at("packets cut") > 0);
}

TEST(Loss, OfTheHostInTheMiddleOfShotsLeavesNothingMissingInItsFolder) {
  expect_nothing_lost({.victim = Victim::host, .kills = 2});
}

TEST(Loss, OfTheFirmwareInTheMiddleOfShotsLeavesNothingMissingAndTheShotsNamed) {
  CHECK(expect_nothing_lost({.victim = Victim::firmware, .kills = 2}).at("boots") >= 3);
}

TEST(Loss, IsTriedOnEachLinkInTurnsAndOnBothSides) {
  CHECK_EQUAL(std::string("no loss"), drawn({}, {1, 1}).name);
  CHECK(drawn({}, {1, 9}).cut_s == 10.0 && drawn({}, {1, 9}).faults.loss == 0.2);
  CHECK(drawn({}, {1, 10}).victim == Victim::host && drawn({}, {1, 10}).kills == 100);
  CHECK(drawn({}, {1, 11}).victim == Victim::firmware);
  CHECK(drawn({.links = true}, {1, 10}).victim == Victim::nobody);
  CHECK(drawn({.kills = 5}, {1, 1}).victim == Victim::host);
}
