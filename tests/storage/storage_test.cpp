// Faults of the disk while a host stores: some dozens, drawn. `tests/storage/run` draws a thousand.
#include <fmt/format.h>

#include <random>

#include "tests/storage/trial.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::storage;
using strobe::testing::DiskFault;
using strobe::testing::parse_disk_fault;

TEST_GROUP(Storage){static Verdict session(const char* fault){
    const Verdict verdict = run_trial({1, "session", *parse_disk_fault(fault)});
CHECK_TEXT(verdict.violation.empty(), (verdict.violation + "; told: " + verdict.told).c_str());
return verdict;
}
}
;

TEST(Storage, EveryDrawnLossIsToldAndNothingToldAsStoredIsMissing) {
  const std::uint64_t first = std::random_device{}();
  for (std::uint64_t seed = first; seed < first + 60; ++seed) {
    const Trial trial = draw(seed);
    const Verdict verdict = run_trial(trial);
    CHECK_TEXT(verdict.violation.empty(),
               fmt::format("{}: {} told: \"{}\"; repeat with strobe-storage --seed {}", to_text(trial.fault),
                           verdict.violation, verdict.told, seed)
                   .c_str());
  }
}

TEST(Storage, AFullDiskEndsTheSeriesWithTheFileAndTheReason) {
  const Verdict verdict = session("file=host-20260131T10,call=write,nth=40,times=1000000,error=28");
  CHECK(verdict.ending == Ending::told_unstored);
  STRCMP_CONTAINS("host-20260131T100000Z.lcmlog: cannot be written: No space left on device",
                  verdict.told.c_str());
}

TEST(Storage, WhatCouldNotBeWrittenIsWrittenWhenTheDiskHasRoomAgain) {
  CHECK(session("file=host-20260131T10,call=write,nth=40,times=3,error=28").ending == Ending::told_stored);
  CHECK(session("file=results.csv,call=write,nth=1,times=2,error=28").ending == Ending::told_stored);
}

TEST(Storage, AShortWriteIsGoneOnWithOrUndone) {
  CHECK(session("file=host-20260131T10,call=write,nth=40,times=1,error=28,short=7").ending ==
        Ending::harmless);
  CHECK(session("file=host-20260131T10,call=write,nth=40,times=2,error=28,short=7").ending ==
        Ending::told_stored);
  CHECK(session("file=results.csv,call=write,nth=1,times=2,error=28,short=100,truncate_too=1").ending ==
        Ending::told_unstored);
  CHECK(session("file=host-20260131T10,call=write,nth=40,times=20,error=4").ending == Ending::harmless);
}

TEST(Storage, ADiskThatFailsInASyncIsNotBelievedAgain) {
  CHECK(session("file=host-20260131T10,call=fsync,nth=1,times=1,error=5").ending == Ending::told_unstored);
}

TEST(Storage, AFolderThatCannotBeWrittenIsRefusedAtTheStart) {
  for (const char* file : {"host-20260131T10", "results.csv", "flashes.csv"})
    CHECK(session(fmt::format("file={},call=open,nth=1,times=1,error=30", file).c_str()).ending ==
          Ending::refused);
}

TEST(Storage, MemoryThatIsRefusedIsToldOrEndsTheProgramDisarmed) {
  for (int nth = 500; nth < 8000; nth += 250)
    session(fmt::format("file=,call=memory,nth={},times=1,error=0", nth).c_str());
}

TEST(Storage, AFolderOrFileThatIsTakenAwayEndsTheSeries) {
  for (const char* what :
       {"file=,call=remove folder", "file=,call=rename folder", "file=results.csv,call=remove file"})
    CHECK(session(fmt::format("{},nth=5", what).c_str()).ending == Ending::told_unstored);
}

TEST(Storage, AFaultIsReadFromItsOwnText) {
  const DiskFault fault = draw(7).fault;
  STRCMP_EQUAL(to_text(fault).c_str(), to_text(*parse_disk_fault(to_text(fault))).c_str());
  CHECK_FALSE(parse_disk_fault("call").has_value());
  CHECK_FALSE(parse_disk_fault("").has_value());
}
