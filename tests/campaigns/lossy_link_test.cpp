#include "tests/campaigns/lossy_link.hpp"

#include <chrono>
#include <lcm/lcm-cpp.hpp>
#include <set>
#include <string>

#include "tests/support/private_network.hpp"
#include "tests/support/process.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::loss;
using namespace std::chrono_literals;
using strobe::testing::private_lcm_url;

namespace {

struct Ear {
  std::multiset<std::string> heard;
  void hear(const lcm::ReceiveBuffer* buffer, const std::string&) {
    heard.emplace(static_cast<const char*>(buffer->data), buffer->data_size);
  }
};

/// Two networks and what crossed between them.
struct Networks {
  std::string url_a = private_lcm_url(), url_b = private_lcm_url();
  lcm::LCM a{url_a}, b{url_b};
  Ear at_a, at_b;
  Networks() {
    a.subscribe("X", &Ear::hear, &at_a)->setQueueCapacity(10'000);
    b.subscribe("X", &Ear::hear, &at_b)->setQueueCapacity(10'000);
  }
  /// Until that much was heard there and here, or the limit has passed, which no busy machine needs; then a
  /// little longer, for what should not come.
  void take_in(std::size_t there, std::size_t here) {
    take_in(10s, [&] { return at_b.heard.size() >= there && at_a.heard.size() >= here; });
    take_in(50ms, [] { return false; });
  }
  template <typename Condition>
  void take_in(std::chrono::milliseconds limit, const Condition& done) {
    const std::int64_t end = strobe::testing::monotonic_now_ns() + std::chrono::nanoseconds(limit).count();
    while (!done() && strobe::testing::monotonic_now_ns() < end) {
      a.handleTimeout(1);
      b.handleTimeout(1);
    }
  }
  void send(lcm::LCM& from, int count) {
    for (int i = 0; i < count; ++i) {
      const std::string text = "message " + std::to_string(i);
      from.publish("X", text.data(), static_cast<unsigned>(text.size()));
    }
  }
};

}  // namespace

TEST_GROUP(LossyLink){};

TEST(LossyLink, CarriesEverythingBothWaysOnce) {
  Networks networks;
  const LossyLink relay(networks.url_a, networks.url_b, {}, 1);
  networks.send(networks.a, 200);
  networks.take_in(200, 200);
  LONGS_EQUAL(200, networks.at_a.heard.size());  // its own network's, and no echo
  LONGS_EQUAL(200, networks.at_b.heard.size());
  networks.send(networks.b, 100);
  networks.take_in(300, 300);
  LONGS_EQUAL(300, networks.at_a.heard.size());
  LONGS_EQUAL(300, relay.counts().came);
}

TEST(LossyLink, LosesDoublesAndDelaysAsOftenAsItIsTold) {
  Networks networks;
  LinkFaults faults;
  faults.loss = 0.5;
  faults.duplication = 0.25;
  faults.reordering = 0.25;
  faults.max_delay_ms = 20;
  const LossyLink relay(networks.url_a, networks.url_b, faults, 1);
  networks.send(networks.a, 1000);
  networks.take_in(10s, [&] { return relay.counts().came == 1000; });
  const LinkCounts counts = relay.counts();
  networks.take_in(static_cast<std::size_t>(1000 - counts.lost + counts.doubled), 1000);
  LONGS_EQUAL(1000, counts.came);
  // Four standard deviations of a count of 1000 at one half, and of 500 at a quarter (once more delayed).
  CHECK(counts.lost > 437 && counts.lost < 563);
  CHECK(counts.doubled > 80 && counts.doubled < 170);
  CHECK(counts.delayed > 100 && counts.delayed < 215);
  LONGS_EQUAL(1000 - counts.lost + counts.doubled, networks.at_b.heard.size());
}

TEST(LossyLink, CarriesNothingWhileItIsCut) {
  Networks networks;
  LossyLink relay(networks.url_a, networks.url_b, {}, 1);
  relay.cut(true);
  networks.send(networks.a, 10);
  networks.take_in(10s, [&] { return relay.counts().cut == 10; });
  networks.take_in(0, 10);
  LONGS_EQUAL(0, networks.at_b.heard.size());
  LONGS_EQUAL(10, relay.counts().cut);
  relay.cut(false);
  networks.send(networks.a, 10);
  networks.take_in(10, 20);
  LONGS_EQUAL(10, networks.at_b.heard.size());
}
