#include "tests/costs/counts.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::costs;

TEST_GROUP(Costs){};

TEST(Costs, TheTotalIsReadFromCallgrindsOutput) {
  LONGS_EQUAL(12345, *total_of("events: Ir\nfn=(1)\n16 4\ntotals: 12345\n"));
  CHECK_FALSE(total_of("events: Ir\n").has_value());
}

TEST(Costs, GrowthUpToATenthIsAccepted) {
  CHECK(complaints({{"reduce", 1000}}, {{"reduce", 1100}}).empty());
  CHECK(complaints({{"reduce", 1000}}, {{"reduce", 500}}).empty());
}

TEST(Costs, MoreFailsWithTheNameAndBothNumbers) {
  const auto lines = complaints({{"reduce", 1000}}, {{"reduce", 1101}});
  CHECK_EQUAL("reduce costs 1101 instructions, +10.1 % on the record's 1000", lines.at(0));
}

TEST(Costs, CasesWithoutARecordAndRecordsWithoutACaseFail) {
  LONGS_EQUAL(2, complaints({{"old", 1}}, {{"new", 1}}).size());
}
