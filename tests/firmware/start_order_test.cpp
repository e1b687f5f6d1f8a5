#include "firmware/publisher/start_order.hpp"

#include <string>

#include "firmware/publisher/journal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::firmware;

TEST_GROUP(StartOrder) {
  strobe::testing::TemporaryFolder folder;

  void add(std::int64_t boot_id) const { CHECK_TRUE(StartOrder::add(folder.path(), boot_id).has_value()); }
};

TEST(StartOrder, IsThatOfTheStarts) {
  CHECK_EQUAL(0u, StartOrder(folder.path()).position(5));
  for (const std::int64_t boot : {std::int64_t{5}, INT64_MAX, std::int64_t{3}}) add(boot);
  const StartOrder order(folder.path());
  CHECK(order.position(4) == 0 && order.position(5) > 0);
  CHECK(order.position(INT64_MAX) > order.position(5));
  CHECK(order.position(3) > order.position(INT64_MAX));
}

TEST(StartOrder, GoesOnBehindWhatAPowerCutTore) {
  add(5);
  add(6);
  const std::string whole = strobe::testing::read_text(folder / "starts");
  for (std::size_t size = 18; size < whole.size(); ++size) {
    strobe::testing::write_text(folder / "starts", whole.substr(0, size));
    add(7);
    const StartOrder order(folder.path());
    CHECK(order.position(5) > 0 && order.position(6) == 0);
    CHECK(order.position(7) > order.position(5));
  }
}

TEST(StartOrder, PassesOverWhatIsNoBoot) {
  strobe::testing::write_text(folder / "starts", std::string("\nxyz\n00000000000000zz\n\xff\n\0\n", 26) +
                                                     "0000000000000007\n000000000000000700");
  CHECK(StartOrder(folder.path()).position(7) > 0);
  CHECK_EQUAL(0u, StartOrder(folder.path()).position(0));
}

TEST(StartOrder, ReadsTheEndOfALongList) {
  std::string text;
  for (std::int64_t boot = 1; boot <= 100'000; ++boot) text += "\n" + boot_in_hex(boot);
  strobe::testing::write_text(folder / "starts", text);
  const StartOrder order(folder.path());
  CHECK_EQUAL(0u, order.position(1));
  CHECK(order.position(100'000) > order.position(99'000));
  CHECK(order.position(99'000) > 0);
  CHECK(order.position(90'000) == 0);
}
