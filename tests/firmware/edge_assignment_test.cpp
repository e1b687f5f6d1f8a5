#include "firmware/core/edge_assignment.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {
constexpr MonoTime kFirst = from_ns(1'000'000'000);
constexpr Duration kPeriod = microseconds(3000);
constexpr Duration kDelay = microseconds(12);
MonoTime at(int flash) { return kFirst + kPeriod * flash; }
}  // namespace

TEST_GROUP(EdgeAssignment) {
  ShotRecord record;
  EdgeAssignment book;
  void setup() override {
    record.flashes.reserve(4);
    book.open(record, kPeriod);
    for (int k = 0; k < 4; ++k) book.plan(at(k));
  }
  void issue(int k, Duration late = {}) { book.issued(k, at(k) + late, at(k) + late + microseconds(1)); }
};

TEST(EdgeAssignment, GivesAnEdgeToTheFlashThatWasIssuedJustBefore) {
  issue(0);
  issue(1);
  book.edge(Input::sensor_a, at(1) + kDelay);
  CHECK_EQUAL(at(1) + kDelay, record.flashes[1].observed_a);
  CHECK_FALSE(known(record.flashes[0].observed_a));
  CHECK_FALSE(known(record.flashes[1].observed_b));
}

TEST(EdgeAssignment, HasAWindowOfHalfAPeriodFromTheIssue) {
  issue(0);
  book.edge(Input::sensor_a, at(0) + kPeriod / 2 - nanoseconds(1));
  book.edge(Input::sensor_b, at(0) + kPeriod / 2);
  CHECK(known(record.flashes[0].observed_a));
  CHECK_FALSE(known(record.flashes[0].observed_b));
  CHECK_EQUAL(1, record.flashes[0].extra_edges);
}

TEST(EdgeAssignment, KeepsTheSensorsApart) {
  issue(0);
  book.edge(Input::sensor_b, at(0) + kDelay);
  CHECK_EQUAL(at(0) + kDelay, record.flashes[0].observed_b);
  CHECK_FALSE(known(record.flashes[0].observed_a));
}

TEST(EdgeAssignment, CountsASecondEdgeAsExtra) {
  issue(0);
  book.edge(Input::sensor_a, at(0) + kDelay);
  book.edge(Input::sensor_a, at(0) + microseconds(700));
  book.edge(Input::sensor_b, at(0) + kDelay);
  CHECK_EQUAL(at(0) + kDelay, record.flashes[0].observed_a);
  CHECK_EQUAL(1, record.flashes[0].extra_edges);
}

TEST(EdgeAssignment, LeavesAMissingFlashMissing) {
  for (int k = 0; k < 3; ++k) issue(k);
  book.edge(Input::sensor_a, at(0) + kDelay);
  book.edge(Input::sensor_a, at(2) + kDelay);
  CHECK_FALSE(known(record.flashes[1].observed_a));
  CHECK(known(record.flashes[2].observed_a));
}

TEST(EdgeAssignment, FollowsAFlashThatWasIssuedLate) {
  // Late by nearly half a period: its light would fall outside a window counted from the commanded instant.
  const Duration late = microseconds(1495);
  issue(0);
  issue(1, late);
  book.edge(Input::sensor_a, at(1) + late + kDelay);
  CHECK_EQUAL(at(1) + late + kDelay, record.flashes[1].observed_a);
}

TEST(EdgeAssignment, CountsLightBetweenTwoFlashesAsExtra) {
  for (int k = 0; k < 4; ++k) issue(k);
  book.edge(Input::sensor_a, at(1) + kDelay);
  book.edge(Input::sensor_a, at(1) + microseconds(1500));  // half a period: too late to be the flash
  book.edge(Input::sensor_b, at(2) - microseconds(21));
  CHECK_EQUAL(at(1) + kDelay, record.flashes[1].observed_a);
  CHECK_FALSE(known(record.flashes[1].observed_b));
  CHECK_EQUAL(2, record.flashes[1].extra_edges);
  CHECK_EQUAL(0, record.flashes[2].extra_edges);
}

TEST(EdgeAssignment, IgnoresLightBeforeAndAfterTheTrain) {
  for (int k = 0; k < 4; ++k) issue(k);
  book.edge(Input::sensor_a, at(0) - microseconds(21));
  book.edge(Input::sensor_a, at(3) + kPeriod);
  for (const FlashRecord& flash : record.flashes) {
    CHECK_FALSE(known(flash.observed_a));
    CHECK_EQUAL(0, flash.extra_edges);
  }
}

TEST(EdgeAssignment, AcceptsAnEdgeALittleBeforeTheIssue) {
  // A configured sensor delay that is somewhat too large puts the corrected stamp before the issue.
  issue(0);
  book.edge(Input::sensor_a, at(0) - microseconds(19));
  CHECK(known(record.flashes[0].observed_a));
}

TEST(EdgeAssignment, KeepsWithinItsCapacity) {
  const auto* before = record.flashes.data();
  for (int k = 4; k < 100; ++k) book.plan(at(k));
  POINTERS_EQUAL(before, record.flashes.data());
}
