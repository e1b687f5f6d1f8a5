// How trials are drawn, counted and named.
#include "tests/campaigns/campaign.hpp"

#include <stdexcept>

#include "tests/support/string_from.hpp"

using namespace strobe::campaigns;

TEST_GROUP(Campaign){};

TEST(Campaign, DrawsTheSameForTheSameSeedAndNumber) {
  CHECK_EQUAL(Draws(7, 3).between(0, 1'000'000), Draws(7, 3).between(0, 1'000'000));
  CHECK(Draws(7, 3).between(0, 1'000'000) != Draws(7, 4).between(0, 1'000'000));
  CHECK(Draws(7, 3).between(0, 1'000'000) != Draws(8, 3).between(0, 1'000'000));
}

TEST(Campaign, NamesTheCommandThatRepeatsATrialWhichFailedOrDidNotCome) {
  const Verdict verdict = judged([](Draws&) -> Verdict { throw std::runtime_error("no rig"); }, 7, 12);
  CHECK_EQUAL("VIOLATION: no rig (); repeat it: strobe-campaign loss --seed 7 --only 12 --kills=5\n",
              complaint(verdict, repetition("loss", 7, 12, " --kills=5")));
}

TEST(Campaign, CountsTrialsByRowsAndKeepsTheLargest) {
  Tables tables;
  tables.add({{}, "", "", {{"fault", "a signal"}}, {{"ended", 1}}, {{"longest, ms", 0.5}}});
  tables.add({{"active"}, "", "", {{"fault", "a signal"}}, {{"ended", 1}}, {{"longest, ms", 0.25}}});
  CHECK_EQUAL(
      "\n| fault | trials | violated | ended | longest, ms |\n|---|---|---|---|---|\n"
      "| a signal | 2 | 1 | 2 | 0.50 |\n",
      tables.text());
  LONGS_EQUAL(1, tables.violated());
}
