// Faults of the disk while a host stores: some dozens.
#include <fmt/format.h>

#include "tests/campaigns/drawn_trials.hpp"
#include "tests/campaigns/storage.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::storage;
using strobe::testing::DiskFault;
using strobe::testing::parse_disk_fault;

namespace {

Outcome session(const std::string& fault) {
  const Outcome outcome = run_trial({"session", *parse_disk_fault(fault)});
  strobe::campaigns::expect_nothing_violated(outcome);
  return outcome;
}

Outcome of_the_log(const std::string& fault) { return session("file=host-20260131T10," + fault); }

}  // namespace

TEST_GROUP(Storage){};

TEST(Storage, EveryDrawnLossIsToldAndNothingToldAsStoredIsMissing) {
  strobe::campaigns::expect_nothing_violated(
      "storage", 60, [](strobe::campaigns::Draws& draws) { return run_trial(drawn(draws)); });
}

TEST(Storage, AFullDiskEndsTheSeriesWithTheFileAndTheReason) {
  const Outcome outcome = of_the_log("call=write,nth=40,times=1000000,error=28");
  CHECK(outcome.ending == Ending::told_unstored);
  STRCMP_CONTAINS("host-20260131T100000Z.lcmlog: cannot be written: No space left on device",
                  outcome.told.c_str());
}

TEST(Storage, WhatCouldNotBeWrittenIsWrittenWhenTheDiskHasRoomAgain) {
  CHECK(of_the_log("call=write,nth=40,times=3,error=28").ending == Ending::told_stored);
  CHECK(session("file=results.csv,call=write,nth=1,times=2,error=28").ending == Ending::told_stored);
}

TEST(Storage, AShortWriteIsGoneOnWithOrUndone) {
  CHECK(of_the_log("call=write,nth=40,times=1,error=28,short=7").ending == Ending::harmless);
  CHECK(of_the_log("call=write,nth=40,times=2,error=28,short=7").ending == Ending::told_stored);
  CHECK(session("file=results.csv,call=write,nth=1,times=2,error=28,short=100,truncate_too=1").ending ==
        Ending::told_unstored);
  CHECK(of_the_log("call=write,nth=40,times=20,error=4").ending == Ending::harmless);
}

TEST(Storage, ADiskThatFailsInASyncIsNotBelievedAgain) {
  CHECK(of_the_log("call=fsync,nth=1,times=1,error=5").ending == Ending::told_unstored);
}

TEST(Storage, AFolderThatCannotBeWrittenIsRefusedAtTheStart) {
  for (const char* file : {"host-20260131T10", "results.csv", "flashes.csv"})
    CHECK(session(fmt::format("file={},call=open,nth=1,times=1,error=30", file)).ending == Ending::refused);
}

TEST(Storage, MemoryThatIsRefusedIsToldOrEndsTheProgramDisarmed) {
  for (int nth = 500; nth < 8000; nth += 250)
    session(fmt::format("file=,call=memory,nth={},times=1,error=0", nth));
}

TEST(Storage, AFolderOrFileThatIsTakenAwayEndsTheSeries) {
  for (const char* what :
       {"file=,call=remove folder", "file=,call=rename folder", "file=results.csv,call=remove file"})
    CHECK(session(fmt::format("{},nth=5", what)).ending == Ending::told_unstored);
}

TEST(Storage, AFaultIsReadFromItsOwnText) {
  const DiskFault fault = drawn({1, 7}).fault;
  STRCMP_EQUAL(to_text(fault).c_str(), to_text(*parse_disk_fault(to_text(fault))).c_str());
  CHECK_FALSE(parse_disk_fault("call").has_value());
  CHECK_FALSE(parse_disk_fault("").has_value());
}
