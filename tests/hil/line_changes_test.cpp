#include "tests/hil/line_changes.hpp"

#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;

TEST_GROUP(LineChanges) {
  const LineChanges changes{{{100, "SHUTTER", 1, "set"},
                             {150, "SHUTTER", 1, "set"},
                             {400, "SHUTTER", 0, "set"},
                             {200, "TRIGGER", 1, "set"},
                             {220, "TRIGGER", 0, "release"},
                             {300, "KEY", 1, "drive"}}};
};

TEST(LineChanges, CountRisesAndNotRepeatedLevels) {
  CHECK_EQUAL(1, changes.rises("SHUTTER"));
  CHECK_EQUAL(0, changes.rises("SHUTTER", 101));
  CHECK_EQUAL(1, changes.rises("TRIGGER", 200, 200));
  CHECK_EQUAL(0, changes.rises("STROBE_A"));
}

TEST(LineChanges, TellTheLevelAtAnInstant) {
  CHECK_EQUAL(0, changes.level_at("SHUTTER", 99));
  CHECK_EQUAL(1, changes.level_at("SHUTTER", 100));
  CHECK_EQUAL(0, changes.level_at("SHUTTER", 400));
}

TEST(LineChanges, TellFromWhenOnTheOutputsAreSafe) {
  CHECK_EQUAL(400, changes.outputs_safe_from(0));
  CHECK_EQUAL(500, changes.outputs_safe_from(500));
  const LineChanges stuck{{{100, "STROBE_B", 1, "set"}}};
  CHECK_EQUAL(INT64_MAX, stuck.outputs_safe_from(0));
}

TEST(LineChanges, TellFromWhenOnTheOutputsAreInactiveWithinASpan) {
  CHECK_EQUAL(400, changes.inactive_from(180, 450));
  CHECK_EQUAL(INT64_MAX, changes.inactive_from(180, 350));
  const LineChanges twice{{{100, "SHUTTER", 1, "set"},
                           {130, "SHUTTER", 0, "set"},
                           {500, "SHUTTER", 1, "set"},
                           {530, "SHUTTER", 0, "set"}}};
  CHECK_EQUAL(130, twice.inactive_from(110, 300));
  CHECK_EQUAL(200, twice.inactive_from(200, 300));
}

TEST(LineChanges, AreReadFromTheChipsFile) {
  const strobe::testing::TemporaryFolder folder;
  strobe::testing::write_text(folder / "changes.csv", "time_ns,line,name,level,cause\n7,3,TRIGGER,1,set\n");
  const LineChanges read(folder / "changes.csv");
  CHECK_EQUAL(1, read.rises("TRIGGER", 7, 7));
}
