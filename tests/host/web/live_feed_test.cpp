// The loop's side: what it tells, how often, and that it never waits.
#include "host/web/live_feed.hpp"

#include <memory>

#include "tests/support/host_bench.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::web;

namespace {

host::Shot shot(int id, std::int64_t host = 7) {
  host::Shot result;
  result.shot_id = id;
  result.boot_id = 77;
  result.host_id = host;
  return result;
}

template <typename Kind>
std::size_t count(const std::deque<LiveMessage>& messages) {
  return static_cast<std::size_t>(std::ranges::count_if(
      messages, [](const auto& message) { return std::holds_alternative<Kind>(message); }));
}

}  // namespace

TEST_GROUP(LiveFeed) {
  testing::ManualClock clock;
  testing::RememberingBus bus;
  host::HostLoop loop{{"bench", {}, 7}, bus, clock};
  LiveChannel channel;
  LiveFeed feed{channel, clock};
  host::ViewModel model;

  void turn(Duration later) {
    clock.now += later;
    loop.run_once();
    feed.step(loop, model, {});
  }
  std::deque<LiveMessage> told() {
    channel.end();  // so that take() does not wait
    return channel.take().messages;
  }
};

TEST(LiveFeed, TellsAShotAtOnce) {
  feed.on_shot_result(shot(3));
  const auto messages = told();
  LONGS_EQUAL(1, count<host::Shot>(messages));
  LONGS_EQUAL(3, std::get<host::Shot>(messages[0]).shot_id);
  CHECK_EQUAL("1970-01-01T00:01:40.000Z", std::get<host::Shot>(messages[0]).utc);
}

TEST(LiveFeed, TellsOnlyShotsThatAreShown) {
  feed.show_only([](std::int64_t host) { return host == 7; });
  feed.on_shot_result(shot(3, 8));
  feed.on_shot_result(shot(4, 7));
  LONGS_EQUAL(1, count<host::Shot>(told()));
}

TEST(LiveFeed, TellsHowThingsAreTwiceASecondWhereNothingChanges) {
  for (int i = 0; i < 100; ++i) turn(milliseconds{20});
  LONGS_EQUAL(4, count<LiveStatus>(told()));
}

TEST(LiveFeed, TellsAtOnceWhatAPersonWaitsFor) {
  turn(milliseconds{20});
  model.activity = "shot 1 of 2: arming";
  turn(milliseconds{20});
  model.danger = "THE OUTPUTS MAY BE ACTIVE";
  turn(milliseconds{20});
  turn(milliseconds{20});
  const auto messages = told();
  LONGS_EQUAL(3, count<LiveStatus>(messages));
  CHECK_EQUAL("THE OUTPUTS MAY BE ACTIVE", std::get<LiveStatus>(messages[2]).danger);
}

TEST(LiveFeed, NeverWaitsForThePageAndKeepsABoundedAmountForIt) {
  // Nobody takes anything: had the loop to wait for room, this would not end.
  constexpr int kMany = 20000;
  for (int i = 0; i < kMany; ++i) {
    feed.on_shot_result(shot(i));
    feed.on_notification("a");
    turn(milliseconds{500});
  }
  LONGS_EQUAL(LiveChannel::kMaxMessages, told().size());
  turn(milliseconds{500});  // what waited for room comes over
  const auto rest = told();
  CHECK(rest.size() <= LiveFeed::kMaxWaiting);
  turn(milliseconds{500});
  const auto last = told();
  LONGS_EQUAL(1, count<LiveNotification>(last));
  CHECK_EQUAL("the page could not keep up: not all that happened is on it",
              std::get<LiveNotification>(last[0]).text);
}
