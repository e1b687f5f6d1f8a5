#include "host/drivers/genicam/frame_count.hpp"

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::genicam;

TEST_GROUP(GenicamFrameCount) {
  FrameCount count{1};

  void check(std::optional<std::uint64_t> id, std::int64_t number, std::int64_t missing) {
    const Counted counted = count.count(id);
    CHECK_EQUAL(number, counted.number);
    CHECK_EQUAL(missing, counted.missing_before);
    CHECK_FALSE(counted.began_anew);
  }
};

TEST(GenicamFrameCount, FramesBetweenIdsAreMissing) {
  check(1, 1, 0);
  check(2, 2, 0);
  check(5, 5, 2);
}

TEST(GenicamFrameCount, FirstFramesAreMissedToo) { check(3, 3, 2); }

TEST(GenicamFrameCount, CameraThatBeginsAnywhereMissesNothing) {
  check(65401, 65401, 0);
  check(65402, 65402, 0);
}

TEST(GenicamFrameCount, IdsOfSixteenBitsBeginAgainAtOne) {
  check(65401, 65401, 0);
  for (int id = 65402; id <= 65535; ++id) check(id, id, 0);
  check(1, 65536, 0);
  check(3, 65538, 1);
  for (int id = 4; id <= 65534; ++id) check(id, 65535 + id, 0);
  check(2, 131'072, 2);  // 65535 and 1 have not come
}

TEST(GenicamFrameCount, FrameWithoutItsFirstPacketIsTheNextOne) {
  check(1, 1, 0);
  check({}, 2, 0);
  check(3, 3, 0);
  check({}, 4, 0);
  check(6, 6, 1);
}

TEST(GenicamFrameCount, StartMayBeginAnewOrNot) {
  check(1, 1, 0);
  check(2, 2, 0);
  count.on_start();
  check(3, 3, 0);
  count.on_start();
  check(1, 1, 0);
  count.on_start();
  check(40'000, 40'000, 0);
}

TEST(GenicamFrameCount, CameraThatBeginsAnewByItselfIsTold) {
  check(1, 1, 0);
  check(2, 2, 0);
  check(3, 3, 0);
  const Counted counted = count.count(2);
  CHECK_TRUE(counted.began_anew);
  CHECK_EQUAL(2, counted.number);
}

TEST(GenicamFrameCount, Usb3VisionBeginsWithNought) {
  count = FrameCount(0);
  check(0, 0, 0);
  check(2, 2, 1);
}
