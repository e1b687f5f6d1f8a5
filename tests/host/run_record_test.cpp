// What a session keeps of each run, and reads back.
#include "host/session/run_record.hpp"

#include <rapidcheck.h>

#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using host::RunRecord;
using testing::TemporaryFolder;
using testing::write_text;

RunRecord example() {
  RunRecord run;
  run.utc = "2026-01-31T09:30:00.123Z";
  run.host_id = 0x7fff'ffff'ffff'ffff;
  run.version = "0.9";
  run.operator_name = "anna@desk";
  run.shots = 10;
  run.until = true;
  run.retries = 3;
  run.notes = {{"spin", "top"}, {"remarks", "wet, \"fast\"\n"}};
  run.plan_file = "plan.toml";
  run.key_fingerprint = "1f2e";
  run.command = {"strobe", "fire", "--until", "10"};
  run.session_shots = 10;
  run.until_known = "e:0.003,mu:1%";
  return run;
}

std::vector<RunRecord> read(const std::string& text) {
  TemporaryFolder folder;
  write_text(folder / "runs.jsonl", text);
  return host::read_runs(folder / "runs.jsonl").value().runs;
}

}  // namespace

TEST_GROUP(RecordOfARun){};

TEST(RecordOfARun, IsReadAsItWasWritten) {
  const RunRecord run = example();
  const std::string line = host::run_line(run);
  CHECK_EQUAL(line.size() - 1, line.find('\n'));
  const RunRecord back = read(line).at(0);
  CHECK_EQUAL(line, host::run_line(back));
  CHECK_EQUAL(run.host_id, back.host_id);
  CHECK_EQUAL("wet, \"fast\"\n", back.notes.at("remarks"));
  STRCMP_CONTAINS("\"host_id\":\"9223372036854775807\"", line.c_str());
}

TEST(RecordOfARun, ComesInTheOrderOfTheStarts) {
  RunRecord second = example();
  second.host_id = 8;
  second.until = false;
  const auto runs = read(host::run_line(example()) + host::run_line(second));
  LONGS_EQUAL(2, runs.size());
  LONGS_EQUAL(8, runs[1].host_id);
  CHECK_FALSE(runs[1].until);
}

TEST(RecordOfARun, IsLeftOutWhereItIsTornOrNoneAtAll) {
  const std::string line = host::run_line(example());
  for (std::size_t cut = 0; cut + 2 < line.size(); ++cut) LONGS_EQUAL(0, read(line.substr(0, cut)).size());
  LONGS_EQUAL(1, read("[]\n7\n{}\n{\"host_id\":7}\n" + line).size());
  LONGS_EQUAL(0, host::read_runs("/nowhere/runs.jsonl")->runs.size());
}

TEST(RecordOfARun, WordsThatAreNoTextAreKeptAsFarAsTheyAre) {
  RunRecord run = example();
  run.command = {"strobe", "\xff\xfe"};
  LONGS_EQUAL(2, read(host::run_line(run)).at(0).command.size());
}

TEST(RecordOfARun, AnyBytesDoNoHarm) {
  CHECK(rc::check("lines are runs or left out", [](const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    RC_ASSERT(read(text + host::run_line(example())).size() >= 1u);
  }));
}
