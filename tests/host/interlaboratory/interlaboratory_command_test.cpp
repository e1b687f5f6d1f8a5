// strobe bundle and strobe compare, as shipped.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "common/authentication/key_file.hpp"
#include "tests/host/archive/written_session.hpp"
#include "tests/support/program_run.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using host_test::WrittenRun;
using testing::read_text;
using testing::write_text;
namespace fs = std::filesystem;

void write_session(const fs::path& folder, const authentication::Key& key) {
  WrittenRun run(folder, key, 5, 0);
  for (int shot = 1; shot <= 3; ++shot) {
    const auto seed = static_cast<std::uint32_t>(shot);
    run.heartbeat();
    run.arm_and_fire();
    run.started(shot);
    run.flash(shot);
    run.ended(shot);
    run.summary(shot, WrittenRun::kBoot, 0, seed);
    run.frame(shot, WrittenRun::kBoot, fmt::format("photographs/shot-000{}-a.png", shot), seed);
  }
  run.wait_s(8.0);
}

}  // namespace

TEST_GROUP(BundleCommand) {
  testing::TemporaryFolder folder;
  authentication::Key key = authentication::make_key_file(folder / "lab.key").value().key;

  void setup() override {
    write_session(folder / "today", key);
    fs::create_directory(folder / "today/photographs");
    for (int shot = 1; shot <= 3; ++shot)
      write_text(folder / "today/photographs" / fmt::format("shot-000{}-a.png", shot), "a photograph");
    strobe({"replay", folder / "today", "--results"});
  }

  testing::CompletedProcess strobe(std::vector<std::string> words) {
    words.insert(words.begin(), STROBE_PROGRAM);
    words.insert(words.end(), {"--key-file", folder / "lab.key"});
    return testing::run_program(std::move(words));
  }
  testing::CompletedProcess bundle(const fs::path& out) { return strobe({"bundle", folder / "today", "--out", out}); }
  testing::CompletedProcess check(const fs::path& archive) { return strobe({"bundle", "--check", archive}); }

  /// The bundle unpacked, changed by these shell commands in the session's folder, and packed again, by tar(1).
  void change(const std::string& commands) {
    const auto run = testing::run_program(
        {"/bin/bash", "-euc",
         "cd '" + folder.path().string() + "'; rm -rf changed; mkdir changed; cd changed; tar xf ../a.tar; cd today; " +
             commands + "; cd ..; tar cf ../changed.tar today"});
    LONGS_EQUAL_TEXT(0, run.status->code, run.err.c_str());
  }
};

TEST(BundleCommand, HandsOverASessionWithTheSameBytesEachTime) {
  testing::check_prints(bundle(folder / "a.tar"), {"3 shots, ", "manifest's SHA-256: "});
  testing::check_prints(bundle(folder / "b.tar"), {"3 shots, "});
  CHECK(read_text(folder / "a.tar") == read_text(folder / "b.tar"));
  testing::check_prints(check(folder / "a.tar"),
                        {"session today, by strobe ", "as they were handed over", "3 shots, 3 counted: computed again, the same bytes"});
}

TEST(BundleCommand, IsComputedAgainByWhoHasNoKey) {
  bundle(folder / "a.tar");
  const auto run = testing::run_program({STROBE_PROGRAM, "bundle", "--check", folder / "a.tar", "--into", folder / "there"},
                                        {{"XDG_CONFIG_HOME", folder / "nobody"}});
  testing::check_prints(run, {"computed again, the same bytes"});
  CHECK(read_text(folder / "there/today/results.csv") == read_text(folder / "today/results.csv"));
  // What was unpacked is a session like any other.
  testing::check_prints(strobe({"series", folder / "there/today"}), {"3 shots counted"});
}

TEST(BundleCommand, IsVerifiedBySha256sumToo) {
  bundle(folder / "a.tar");
  change("sha256sum --check --quiet MANIFEST.sha256");
}

TEST(BundleCommand, NamesWhatWasChanged) {
  bundle(folder / "a.tar");
  change("printf b > photographs/shot-0002-a.png; rm photographs/shot-0003-a.png; echo more > new.txt");
  const auto run = check(folder / "changed.tar");
  LONGS_EQUAL(1, run.status->code);
  STRCMP_CONTAINS("! photographs/shot-0002-a.png: is not what was handed over\n", run.out.c_str());
  STRCMP_CONTAINS("! photographs/shot-0003-a.png: is missing\n", run.out.c_str());
  STRCMP_CONTAINS("! new.txt: is not in the manifest\n", run.out.c_str());
}

TEST(BundleCommand, NamesEachByteThatIsChanged) {
  bundle(folder / "a.tar");
  const std::string whole = read_text(folder / "a.tar");
  const std::size_t at = whole.find("a photograph");
  std::string changed = whole;
  changed[at] = 'A';
  write_text(folder / "changed.tar", changed);
  const auto run = check(folder / "changed.tar");
  LONGS_EQUAL(1, run.status->code);
  STRCMP_CONTAINS("! photographs/shot-0001-a.png: is not what was handed over\n", run.out.c_str());
}

TEST(BundleCommand, FindsNumbersThatWereChangedWithTheirHash) {
  bundle(folder / "a.tar");
  change("sed -i '3s/[.]/.9/6' results.csv; h=$(sha256sum results.csv); sed -i \"s/.*  results.csv\\$/$h/\" MANIFEST.sha256");
  const auto run = check(folder / "changed.tar");
  LONGS_EQUAL(1, run.status->code);
  STRCMP_CONTAINS("! results.csv: computed again it is not the same, first in line 3\n", run.out.c_str());
}

TEST(BundleCommand, HoldsTheVerdictOfASessionsProtocolWhichIsComputedAgain) {
  write_text(folder / "today/protocol.toml", R"toml(title = "Restitution"
[source]
document = "none"
read = "whole"
[test]
repeats = 3
[impact]
kind = "thrown"
speed_mps = 17
angle_deg = 23
[[computed]]
name = "restitution"
words = "restitution"
level = "test"
formula = "mean(e)"
[[requirement]]
name = "restitution"
least = 0.1
most = 0.2
)toml");
  bundle(folder / "a.tar");
  change("grep -q Restitution verdict.txt");
  testing::check_prints(check(folder / "a.tar"), {"computed again, the same bytes", "Restitution\n"});
  change("echo pass > verdict.txt; h=$(sha256sum verdict.txt); sed -i \"s/.*  verdict.txt/$h/\" MANIFEST.sha256");
  const auto run = check(folder / "changed.tar");
  LONGS_EQUAL(1, run.status->code);
  STRCMP_CONTAINS("! verdict.txt: computed again it is not the same\n", run.out.c_str());
}

TEST(BundleCommand, IsNotMadeOfATableThatTheSessionDoesNotSay) {
  const std::string table = read_text(folder / "today/results.csv");
  write_text(folder / "today/results.csv", table + table.substr(table.rfind('\n', table.size() - 2) + 1));
  const auto run = bundle(folder / "a.tar");
  LONGS_EQUAL(1, run.status->code);
  STRCMP_CONTAINS("--results makes it anew", run.err.c_str());
  CHECK_FALSE(fs::exists(folder / "a.tar"));
}

TEST(BundleCommand, LeavesKeysAndWhatIsHiddenAndRefusesLinks) {
  fs::copy_file(folder / "lab.key", folder / "today/lab.key");
  write_text(folder / "today/.hidden", "x");
  const auto run = bundle(folder / "a.tar");
  testing::check_prints(run, {"3 shots"});
  STRCMP_CONTAINS("lab.key is a lab's key, and stays here", run.err.c_str());
  CHECK(read_text(folder / "a.tar").find(key.text()) == std::string::npos);
  CHECK(read_text(folder / "a.tar").find(".hidden") == std::string::npos);
  fs::create_symlink(folder / "lab.key", folder / "today/link");
  STRCMP_CONTAINS("link: is a link, which no bundle holds", bundle(folder / "b.tar").err.c_str());
}

TEST(BundleCommand, RefusesWhatItCannotUseInOneLine) {
  write_text(folder / "text.tar", "no archive at all");
  const std::vector<std::pair<std::vector<std::string>, const char*>> cases{
      {{"bundle"}, "give a session's folder, or --check"},
      {{"bundle", folder / "today"}, "give --out FILE.tar"},
      {{"bundle", folder / "absent", "--out", folder / "a.tar"}, "no such folder"},
      {{"bundle", "--check", folder / "absent.tar"}, "absent.tar"},
      {{"bundle", "--check", folder / "text.tar"}, "no tar archive"},
      {{"bundle", "--check", folder / "a.tar", "--into", folder / "today"}, "is not empty"}};
  for (const auto& [words, complaint] : cases) {
    const auto run = strobe(words);
    LONGS_EQUAL_TEXT(2, run.status->code, complaint);
    STRCMP_CONTAINS(complaint, run.err.c_str());
    LONGS_EQUAL_TEXT(1, std::count(run.err.begin(), run.err.end(), '\n'), run.err.c_str());
  }
}

TEST(BundleCommand, IsComparedWithAnotherLaboratorysSeries) {
  // Two laboratories' JSON of the same session: what they measured agrees to the last digit.
  const auto series = strobe({"series", folder / "today", "--json"});
  write_text(folder / "north.jsonl", series.out);
  write_text(folder / "south.jsonl", series.out);
  const auto run = testing::run_program({STROBE_PROGRAM, "compare", "north=" + (folder / "north.jsonl").string(),
                                         folder / "south.jsonl", "--quantity", "e,v_td_mps", "--figure", folder / "figures", "--json"});
  const auto told = testing::jsons_of(run);
  LONGS_EQUAL(2, told.size());
  DOUBLES_EQUAL(0.0, told[0]["results"][1]["en"]["value"].get<double>(), 0.0);
  STRCMP_CONTAINS("north", read_text(folder / "figures/laboratories.svg").c_str());
  const auto refused = testing::run_program(
      {STROBE_PROGRAM, "compare", folder / "north.jsonl", folder / "south.jsonl", "--assessment-sd", "e:no"});
  testing::check_refused(refused, "compare: --assessment-sd e:no: as e:0.005, the number above 0");
}
