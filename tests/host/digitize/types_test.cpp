#include "host/digitize/core/types.hpp"

#include <set>

#include <CppUTest/TestHarness.h>

using strobe::digitize::name;
using strobe::digitize::Reason;

TEST_GROUP(Reason){};

TEST(Reason, HasANameOfItsOwn) {
  std::set<std::string_view> names;
  const int count = static_cast<int>(Reason::by_hand) + 1;
  for (int i = 0; i < count; ++i) names.insert(name(static_cast<Reason>(i)));
  LONGS_EQUAL(count, names.size());
}
