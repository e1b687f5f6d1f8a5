// The record of commissioning: written and read again, and how it stands on a day.
#include "host/commission/record/record.hpp"

#include <fmt/format.h>

#include <chrono>
#include <string>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;
using State = Standing::State;

constexpr const char* kRig =
    "rig = \"bench\"\n[lamps]\ndelay_us = 12.0\n[shutter]\nlag_ms = 45\n[record]\noperator = \"a\"\n"
    "[commission]\nmax_age_days = 30\n";

host::RigFile rig_of(const std::string& text) { return *host::read_rig(text, "rig.toml"); }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

const std::vector<StepInfo> kInfos{{"lamp_a", "lamp A alone", {"lamps"}}, {"shutter", "lag", {"shutter"}}};

RecordedStep step_of(const StepInfo& info, StepState state, const host::RigFile& rig, const char* utc) {
  RecordedStep step{utc, "a@b", "1", "bench", tables_hash(rig, info.tables), info.title, {}};
  step.result.id = info.id;
  step.result.state = state;
  return step;
}

/// 2026-11-23
WallTime day(int later = 0) {
  using namespace std::chrono;
  return WallTime{sys_days{year{2026} / 11 / 23}.time_since_epoch() + hours{24 * later}};
}

}  // namespace

TEST_GROUP(CommissionRecord) {
  host::RigFile rig = rig_of(kRig);

  Record whole(StepState lamp = StepState::passed) {
    Record record;
    record.steps = {step_of(kInfos[0], lamp, rig, "2026-11-23T10:00:00.000Z"),
                    step_of(kInfos[1], StepState::passed, rig, "2026-11-23T10:01:00.000Z")};
    return record;
  }
};

TEST(CommissionRecord, ReadsBackAsItWasWritten) {
  RecordedStep step = step_of(kInfos[0], StepState::failed, rig, "2026-11-23T10:00:00.000Z");
  step.result.value = 12.25;
  step.result.sd = 0.5;
  step.result.unit = "us";
  step.result.limit = "12 ± 3 us";
  step.result.words = "it says \"no\" <b>";
  step.result.advice = "mend it";
  step.result.fault = "delay_off";
  step.result.figures = {{"delay_a_us", 12.25, 0.5, 12.0, 100}, {"flashes", 100.0, {}, {}, 0}};
  const Record read = parse_record(record_line(step));
  CHECK_EQUAL(std::size_t{1}, read.steps.size());
  CHECK_EQUAL(record_line(step), record_line(read.steps[0]));
  CHECK_FALSE(read.torn);
}

TEST(CommissionRecord, KeepsEachOutcome) {
  for (const auto& [state, word] : {std::pair{StepState::passed, "passed"},
                                    {StepState::failed, "failed"},
                                    {StepState::skipped, "skipped"},
                                    {StepState::not_told, "not_told"}}) {
    const std::string line = record_line(step_of(kInfos[0], state, rig, "2026-11-23T10:00:00.000Z"));
    STRCMP_CONTAINS(fmt::format("\"state\":\"{}\"", word).c_str(), line.c_str());
    CHECK_TRUE(parse_record(line).steps.at(0).result.state == state);
  }
}

TEST(CommissionRecord, TellsOfATornLineAndKeepsTheRest) {
  const std::string line =
      record_line(step_of(kInfos[0], StepState::passed, rig, "2026-11-23T10:00:00.000Z"));
  const Record read = parse_record(line + line.substr(0, line.size() / 2));
  CHECK_EQUAL(std::size_t{1}, read.steps.size());
  CHECK_EQUAL(std::size_t{1}, read.remarks.size());
  CHECK_TRUE(read.torn);
}

TEST(CommissionRecord, SurvivesEveryCutOfItsText) {
  const std::string text =
      record_line(step_of(kInfos[0], StepState::passed, rig, "2026-11-23T10:00:00.000Z"));
  for (std::size_t cut = 0; cut < text.size(); ++cut) {
    const Record read = parse_record(std::string_view(text).substr(0, cut));
    CHECK_TRUE(read.steps.size() <= (cut + 1 >= text.size() ? 1U : 0U));
  }
}

TEST(CommissionRecord, HashesWhatAStepDependsOnAndNoMore) {
  const auto lamps = [](const std::string& text) { return tables_hash(rig_of(text), {"lamps"}); };
  CHECK_EQUAL(lamps(kRig), lamps("# a remark\n" + replaced(kRig, "operator = \"a\"", "operator = \"b\"")));
  CHECK_EQUAL(lamps(kRig), lamps(replaced(kRig, "delay_us = 12.0", "delay_us =   12.0  # us")));
  CHECK_TRUE(lamps(kRig) != lamps(replaced(kRig, "delay_us = 12.0", "delay_us = 12.5")));
  CHECK_EQUAL(lamps(kRig), lamps(replaced(kRig, "lag_ms = 45", "lag_ms = 46")));
}

TEST(CommissionRecord, StandsWhereAllHasPassedOnThisRigFile) {
  const Record record = whole();
  const Standing stands = standing(record, kInfos, rig, day());
  CHECK_TRUE_TEXT(stands.state == State::good, stands.words.c_str());
  CHECK_EQUAL("commissioned on 2026-11-23", stands.words);
  CHECK_TRUE(standing({}, kInfos, rig, day()).state == State::absent);
}

TEST(CommissionRecord, TellsWhatFailedIsMissingIsOldOrCameBeforeAChange) {
  const Record bad = whole(StepState::failed);
  CHECK_EQUAL("commissioned on 2026-11-23; failed: lamp_a", standing(bad, kInfos, rig, day()).words);
  Record half = whole();
  half.steps.pop_back();
  CHECK_EQUAL("commissioned on 2026-11-23; never done: shutter", standing(half, kInfos, rig, day()).words);
  const Record record = whole();
  CHECK_TRUE(standing(record, kInfos, rig, day(30)).state == State::good);
  CHECK_EQUAL("commissioned on 2026-11-23; too old: lamp_a, shutter",
              standing(record, kInfos, rig, day(31)).words);
  CHECK_EQUAL("commissioned on 2026-11-23; before the rig file's change: shutter",
              standing(record, kInfos, rig_of(replaced(kRig, "lag_ms = 45", "lag_ms = 46")), day()).words);
}

TEST(CommissionRecord, IsInDoubtWhereALimitWasNotTold) {
  const Record record = whole(StepState::not_told);
  const Standing stands = standing(record, kInfos, rig, day());
  CHECK_TRUE(stands.state == State::doubtful);
  CHECK_EQUAL("commissioned on 2026-11-23; not told apart from the limit: lamp_a", stands.words);
}

TEST(CommissionRecord, TellsWhatWasLeftOut) {
  const Record record = whole(StepState::skipped);
  const Standing stands = standing(record, kInfos, rig, day());
  CHECK_TRUE(stands.state == State::good);
  CHECK_EQUAL("commissioned on 2026-11-23; left out: lamp_a", stands.words);
}

TEST(CommissionRecord, TheNewestResultOfAStepCounts) {
  Record record = whole(StepState::failed);
  record.steps.push_back(step_of(kInfos[0], StepState::passed, rig, "2026-11-23T11:00:00.000Z"));
  CHECK_TRUE(standing(record, kInfos, rig, day()).state == State::good);
}

TEST(CommissionRecord, LiesBesideTheRigFile) {
  CHECK_EQUAL(std::string("/lab/rig.commission.jsonl"), record_path("/lab/rig.toml", {}).string());
  host::CommissionTable elsewhere;
  elsewhere.record = "proofs/bench.jsonl";
  CHECK_EQUAL(std::string("/lab/proofs/bench.jsonl"), record_path("/lab/rig.toml", elsewhere).string());
}
