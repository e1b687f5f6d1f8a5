#include "tests/support/recorded.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::testing;

TEST_GROUP(Recorded){};

TEST(Recorded, LinesAreAlikeWithinATolerance) {
  CHECK_TRUE(alike("a 1.00 b", "a 1.01 b", 0.02));
  CHECK_FALSE(alike("a 1.00 b", "a 1.03 b", 0.02));
  CHECK_FALSE(alike("a 1.00 b", "a 1.00 c", 0.02));
  CHECK_FALSE(alike("a 1.00", "a 1.00 b", 0.02));
  CHECK_FALSE(alike("a 1.00", "a nan", 0.02));
  CHECK_TRUE(alike("a nan", "a nan", 0.02));
}

TEST(Recorded, ATextWithoutARecordDiffersFromItsFirstLineOn) {
  STRCMP_EQUAL("\n- \n+ # one", difference_from_record("no such record", "# one\ntwo\n", 0.0).c_str());
}
