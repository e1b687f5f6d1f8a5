#include "tests/support/error_of.hpp"

#include "common/result.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using strobe::testing::error_of;

TEST_GROUP(ErrorOf){};

TEST(ErrorOf, IsWhatIsSaidAgainstSomethingAndEmptyOtherwise) {
  CHECK_EQUAL("", error_of(Result<int>(3)));
  CHECK_EQUAL("a.toml:1: no", error_of(Result<int>(fail("a.toml:1: no"))));
}
