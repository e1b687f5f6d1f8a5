#include "firmware/publisher/loop_queue.hpp"

#include <thread>

#include "firmware/linux/event_fd.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::firmware;

TEST_GROUP(LoopQueue) {
  Rig rig;
  EventFd wake;
  LoopQueue queue{rig, wake};
  bool woken() { return wake.take() > 0; }
  Event numbered(int number) const {
    Event event;
    event.flash_index = number;
    return event;
  }
};

TEST(LoopQueue, KeepsTheOrderOfWhatHappened) {
  queue.event(numbered(1));
  LoopStatus status;
  status.last_shot_id = 9;
  queue.status(status);
  ShotRecord* record = queue.free_record();
  CHECK_TRUE(queue.shot_done(record));
  LoopQueue::Item item;
  CHECK_TRUE(queue.pop(item));
  CHECK_EQUAL(1, std::get<Event>(item).flash_index);
  CHECK_TRUE(queue.pop(item));
  CHECK_EQUAL(9, std::get<LoopStatus>(item).last_shot_id);
  CHECK_TRUE(queue.pop(item));
  POINTERS_EQUAL(record, std::get<ShotRecord*>(item));
  CHECK_FALSE(queue.pop(item));
}

TEST(LoopQueue, WakesThePublisherOnlyWhenThereIsNews) {
  queue.flush();
  CHECK_FALSE(woken());
  queue.event(numbered(1));
  CHECK_FALSE(woken());
  queue.flush();
  CHECK_TRUE(woken());
  queue.flush();
  CHECK_FALSE(woken());
  queue.status(LoopStatus{});
  queue.flush();
  CHECK_TRUE(woken());
  CHECK_TRUE(queue.shot_done(queue.free_record()));
  queue.flush();
  CHECK_TRUE(woken());
}

TEST(LoopQueue, CountsWhatItCannotTakeAndNeverWaits) {
  const int more = static_cast<int>(LoopQueue::kCapacity) * 2;
  for (int i = 0; i < more; ++i) queue.event(numbered(i));
  LoopQueue::Item item;
  std::int64_t taken = 0;
  while (queue.pop(item)) ++taken;
  CHECK(taken >= static_cast<std::int64_t>(LoopQueue::kCapacity));
  CHECK_EQUAL(more, taken + queue.overflows());
}

TEST(LoopQueue, DeliversTheLastStatusAfterItWasFull) {
  while (queue.overflows() == 0) queue.event(numbered(0));
  LoopStatus status;
  status.last_shot_id = 5;
  queue.status(status);
  LoopQueue::Item item;
  while (queue.pop(item)) CHECK_TRUE(std::holds_alternative<Event>(item));
  queue.flush();
  CHECK_TRUE(queue.pop(item));
  CHECK_EQUAL(5, std::get<LoopStatus>(item).last_shot_id);
}

TEST(LoopQueue, DeliversNoStatusAfterANewerOne) {
  while (queue.overflows() == 0) queue.event(numbered(0));
  LoopStatus status;
  queue.status(status);  // finds no room
  LoopQueue::Item item;
  while (queue.pop(item)) {
  }
  status.last_shot_id = 6;
  queue.status(status);
  queue.flush();
  CHECK_TRUE(queue.pop(item));
  CHECK_EQUAL(6, std::get<LoopStatus>(item).last_shot_id);
  CHECK_FALSE(queue.pop(item));
}

TEST(LoopQueue, LendsEachRecordOnceUntilItIsGivenBack) {
  ShotRecord* records[LoopQueue::kRecords];
  for (ShotRecord*& record : records) {
    record = queue.free_record();
    CHECK(record != nullptr);
    CHECK(record->flashes.capacity() >= static_cast<std::size_t>(rig.lamps.max_flashes));
    CHECK_TRUE(queue.shot_done(record));
  }
  POINTERS_EQUAL(nullptr, queue.free_record());
  queue.give_back(records[2]);
  POINTERS_EQUAL(records[2], queue.free_record());
}

TEST(LoopQueue, LosesNothingUncountedBetweenTwoThreads) {
  constexpr int kCount = 50'000;
  std::thread loop([this] {
    for (int i = 0; i < kCount; ++i) {
      queue.event(numbered(i));
      if (i % 64 == 0) std::this_thread::yield();
    }
  });
  LoopQueue::Item item;
  std::int64_t taken = 0;
  int last = -1;
  while (taken + queue.overflows() < kCount) {
    if (!queue.pop(item)) continue;
    const int number = std::get<Event>(item).flash_index;
    CHECK(number > last);
    last = number;
    ++taken;
  }
  loop.join();
  CHECK_EQUAL(kCount, taken + queue.overflows());
}
