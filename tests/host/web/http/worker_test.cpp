#include "host/web/http/worker.hpp"

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "tests/support/string_from.hpp"

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
