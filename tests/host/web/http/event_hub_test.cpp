#include <atomic>
#include <fmt/format.h>
#include <memory>
#include <thread>
#include <vector>

#include "host/web/http/event_hub.hpp"
#include "host/web/http/worker.hpp"
#include "tests/support/string_from.hpp"

using strobe::web::EventHub;

namespace {

constexpr std::size_t kRoom = 1 << 20;

}  // namespace

TEST_GROUP(WebEventHub) { EventHub hub{100}; };

TEST(WebEventHub, GivesEachViewerWhatHeHasNotSeen) {
  const auto start = hub.last_id();
  hub.publish("shot", "{\"name\":\"1\"}");
  hub.publish("series", "{}");
  const auto all = hub.take_after(start, kRoom);
  CHECK_EQUAL("id: 100\nevent: shot\ndata: {\"name\":\"1\"}\n\nid: 101\nevent: series\ndata: {}\n\n",
              all.text);
  LONGS_EQUAL(101, all.last_id);
  CHECK_EQUAL("id: 101\nevent: series\ndata: {}\n\n", hub.take_after(100, kRoom).text);
  CHECK_EQUAL("", hub.take_after(101, kRoom).text);
}

TEST(WebEventHub, KeepsAnEventOnOneLine) {
  hub.publish("notification", "{\"text\":\n\r\"a\"}");
  CHECK_EQUAL("id: 100\nevent: notification\ndata: {\"text\":  \"a\"}\n\n", hub.take_after(99, kRoom).text);
}

TEST(WebEventHub, TellsAViewerWhoComesBackTooLateToFetchEverythingAnew) {
  for (std::size_t i = 0; i <= EventHub::kMaxKept; ++i) hub.publish("status", "{}");
  const auto late = hub.take_after(99, kRoom);
  CHECK_EQUAL(fmt::format("id: {}\nevent: reset\ndata: {{}}\n\n", hub.last_id()), late.text);
  LONGS_EQUAL(hub.last_id(), late.last_id);
  STRCMP_CONTAINS("id: 101\n", hub.take_after(100, kRoom).text.c_str());
}

TEST(WebEventHub, TellsAViewerOfAnotherServerToFetchEverythingAnew) {
  hub.publish("status", "{}");
  for (const std::int64_t seen : {std::int64_t{-1}, std::int64_t{5}, std::int64_t{101}, INT64_MAX, INT64_MIN})
    STRCMP_CONTAINS("event: reset\n", hub.take_after(seen, kRoom).text.c_str());
}

TEST(WebEventHub, KeepsABoundedAmountWhateverIsPublished) {
  const std::string large(EventHub::kMaxKept_bytes / 4, 'x');
  for (int i = 0; i < 10; ++i) hub.publish("series", large);
  STRCMP_CONTAINS("event: reset\n", hub.take_after(99, kRoom).text.c_str());
  CHECK(hub.take_after(106, 10 * EventHub::kMaxKept_bytes).text.size() <= EventHub::kMaxKept_bytes);
  LONGS_EQUAL(109, hub.take_after(106, 10 * EventHub::kMaxKept_bytes).last_id);
}

TEST(WebEventHub, GivesASlowViewerPiecesOfWholeEventsAndOneAtLeast) {
  hub.publish("a", "{}");
  hub.publish("b", "{}");
  const auto piece = hub.take_after(99, 1);
  CHECK_EQUAL("id: 100\nevent: a\ndata: {}\n\n", piece.text);
  LONGS_EQUAL(100, piece.last_id);
}

TEST(WebEventHub, LosesNothingOfSeveralPublishers) {
  int woken = 0;
  hub.set_wake([&woken] { ++woken; });
  const auto publish = [this] {
    for (int i = 0; i < 100; ++i) hub.publish("status", "{}");
  };
  std::thread first(publish), second(publish);
  std::int64_t seen = 99, pieces = 0;
  while (seen < 299) {
    const auto taken = hub.take_after(seen, 100);
    CHECK(taken.text.find("reset") == std::string::npos);
    if (!taken.text.empty()) ++pieces;
    seen = taken.last_id;
  }
  first.join();
  second.join();
  LONGS_EQUAL(299, seen);
  LONGS_EQUAL(200, woken);
  CHECK(pieces > 1);
}

using strobe::web::Worker;

namespace {

/// Shared with a job that may outlive its test.
struct Gate {
  std::atomic<bool> begun{false}, open{false}, done{false};
  void pass() {
    begun = true;
    begun.notify_all();
    open.wait(false);
    done = true;
    done.notify_all();
  }
};

}  // namespace

TEST_GROUP(WebWorker) { std::shared_ptr<Gate> gate = std::make_shared<Gate>(); };

TEST(WebWorker, DoesOneJobAfterTheOtherInTheirOrder) {
  std::vector<int> order;
  std::atomic<bool> last{false};
  Worker worker(100);
  for (int i = 0; i < 50; ++i) CHECK(worker.add([&order, i] { order.push_back(i); }));
  CHECK(worker.add([&last] {
    last = true;
    last.notify_all();
  }));
  last.wait(false);
  LONGS_EQUAL(50, order.size());
  for (int i = 0; i < 50; ++i) LONGS_EQUAL(i, order[static_cast<std::size_t>(i)]);
}

TEST(WebWorker, RefusesAJobWhenItsQueueIsFull) {
  Worker worker(2);
  CHECK(worker.add([gate = gate] { gate->pass(); }));
  gate->begun.wait(false);
  CHECK(worker.add([] {}));
  CHECK(worker.add([] {}));
  CHECK(!worker.add([] {}));
  gate->open = true;
  gate->open.notify_all();
}

TEST(WebWorker, AtItsEndDropsWhatWaitsAndTakesNoMore) {
  Worker worker(2);
  CHECK(worker.end());
  CHECK(!worker.add([] {}));
}

TEST(WebWorker, DoesNotWaitForAJobThatGoesOnAndSaysSo) {
  Worker worker(2);
  CHECK(worker.add([gate = gate] { gate->pass(); }));
  gate->begun.wait(false);
  CHECK(!worker.end());
  CHECK(strobe::web::work_left_behind());
  gate->open = true;
  gate->open.notify_all();
  gate->done.wait(false);
}
