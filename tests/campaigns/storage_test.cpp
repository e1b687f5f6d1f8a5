// Faults of the disk while a host stores: some dozens.
#include <fmt/format.h>

#include <algorithm>

#include "tests/campaigns/drawn_trials.hpp"
#include "tests/campaigns/storage.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::storage;
using strobe::testing::DiskFault;
using strobe::testing::parse_disk_fault;

namespace {

const std::string kUnstored = "told, unstored named", kStored = "told, stored after all";

/// How it ended.
std::string session(const std::string& fault, const std::string& told = "") {
  const auto verdict = run_trial({"session", *parse_disk_fault(fault)});
  strobe::campaigns::expect_nothing_violated(verdict);
  STRCMP_CONTAINS(told.c_str(), verdict.words.c_str());
  return std::ranges::max_element(verdict.counts, {}, [](const auto& count) { return count.second; })->first;
}

std::string of_the_log(const std::string& fault, const std::string& told = "") {
  return session("file=host-20260131T10," + fault, told);
}

}  // namespace

TEST_GROUP(Storage){};

TEST(Storage, EveryDrawnLossIsToldAndNothingToldAsStoredIsMissing) {
  strobe::campaigns::expect_nothing_violated(
      "storage", 60, [](strobe::campaigns::Draws& draws) { return run_trial(drawn(draws)); });
}

TEST(Storage, AFullDiskEndsTheSeriesWithTheFileAndTheReason) {
  CHECK_EQUAL(kUnstored,
              of_the_log("call=write,nth=40,times=1000000,error=28",
                         "host-20260131T100000Z.lcmlog: cannot be written: No space left on device"));
}

TEST(Storage, WhatCouldNotBeWrittenIsWrittenWhenTheDiskHasRoomAgain) {
  CHECK_EQUAL(kStored, of_the_log("call=write,nth=40,times=3,error=28"));
  CHECK_EQUAL(kStored, session("file=results.csv,call=write,nth=1,times=2,error=28"));
}

TEST(Storage, AShortWriteIsGoneOnWithOrUndone) {
  CHECK_EQUAL("harmless", of_the_log("call=write,nth=40,times=1,error=28,short=7"));
  CHECK_EQUAL(kStored, of_the_log("call=write,nth=40,times=2,error=28,short=7"));
  CHECK_EQUAL(kUnstored,
              session("file=results.csv,call=write,nth=1,times=2,error=28,short=100,truncate_too=1"));
  CHECK_EQUAL("harmless", of_the_log("call=write,nth=40,times=20,error=4"));
}

TEST(Storage, ADiskThatFailsInASyncIsNotBelievedAgain) {
  CHECK_EQUAL(kUnstored, of_the_log("call=fsync,nth=1,times=1,error=5"));
}

TEST(Storage, AFolderThatCannotBeWrittenIsRefusedAtTheStart) {
  for (const char* file : {"host-20260131T10", "results.csv", "flashes.csv"})
    CHECK_EQUAL("refused", session(fmt::format("file={},call=open,nth=1,times=1,error=30", file)));
}

TEST(Storage, MemoryThatIsRefusedIsToldOrEndsTheProgramDisarmed) {
  for (int nth = 500; nth < 8000; nth += 250)
    session(fmt::format("file=,call=memory,nth={},times=1,error=0", nth));
}

TEST(Storage, AFolderOrFileThatIsTakenAwayEndsTheSeries) {
  for (const char* what :
       {"file=,call=remove folder", "file=,call=rename folder", "file=results.csv,call=remove file"})
    CHECK_EQUAL(kUnstored, session(fmt::format("{},nth=5", what)));
}

TEST(Storage, AFaultIsReadFromItsOwnText) {
  const DiskFault fault = drawn({1, 7}).fault;
  STRCMP_EQUAL(to_text(fault).c_str(), to_text(*parse_disk_fault(to_text(fault))).c_str());
  CHECK_FALSE(parse_disk_fault("call").has_value());
  CHECK_FALSE(parse_disk_fault("").has_value());
}
