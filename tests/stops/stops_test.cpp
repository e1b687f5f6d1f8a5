// A stop stays a stop, whatever is lost, late or repeated between firmware and hosts.
#include <cstdio>

#include "tests/stops/search.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::stops;

TEST_GROUP(Stops){};

TEST(Stops, NoStateLeadsToATriggerWithoutAPersonAfterAStop) {
  const Found found = search({});
  std::printf("stops: %s\n", in_words(found).c_str());
  CHECK_EQUAL("", found.wrong);
}
