#include "tests/fuzz/mutate.hpp"

#include <set>
#include <string>
#include <vector>

#include "tests/support/string_from.hpp"

using strobe::fuzz::mutated;

TEST_GROUP(Mutate) { const std::vector<std::string> seeds{"{\"a\":12.5,\"b\":[1,2]}", "key = 3\n"}; };

TEST(Mutate, RepeatsARunFromItsSeedAndNumber) {
  for (std::uint64_t run = 0; run < 100; ++run) CHECK_EQUAL(mutated(seeds, 7, run), mutated(seeds, 7, run));
}

TEST(Mutate, ReachesManyDifferentInputs) {
  // Some changes undo each other or hit the same byte; half of the runs being new is far below what is seen.
  std::set<std::string> seen;
  for (std::uint64_t run = 0; run < 1000; ++run) seen.insert(mutated(seeds, 1, run));
  CHECK(seen.size() > 500);
}

TEST(Mutate, DiffersFromOneSeedToTheNext) {
  int same = 0;
  for (std::uint64_t run = 0; run < 100; ++run)
    same += mutated(seeds, 1, run) == mutated(seeds, 2, run) ? 1 : 0;
  CHECK(same < 10);
}

TEST(Mutate, StartsFromNothingWhereThereAreNoSeeds) { CHECK(mutated({}, 1, 1).size() <= (1U << 16)); }
