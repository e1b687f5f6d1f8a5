// strobe report, as shipped, on folders that hosts wrote.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "common/authentication/key_file.hpp"
#include "tests/host/archive/written_session.hpp"
#include "tests/host/report/parsed_html.hpp"
#include "tests/support/program_run.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using host_test::WrittenRun;
using nlohmann::json;
using testing::read_text;
namespace fs = std::filesystem;

constexpr const char* kRig =
    "rig = \"bench\"\n[machine]\nlag_ms = 310\n[record]\nball_name = \"<b>new</b>\"\n[laboratory]\nname = "
    "\"Lab\"\n";

}  // namespace

TEST_GROUP(ReportCommand) {
  testing::TemporaryFolder folder;
  authentication::Key key = authentication::make_key_file(folder / "lab.key").value().key;

  void setup() override {
    WrittenRun run(folder / "today", key, 5, 0, kRig);
    for (int shot = 1; shot <= 3; ++shot) {
      const auto seed = static_cast<std::uint32_t>(shot);
      run.heartbeat();
      run.arm_and_fire();
      run.started(shot);
      run.flash(shot);
      run.ended(shot);
      run.summary(shot, WrittenRun::kBoot, 0, seed);
      run.frame(shot, WrittenRun::kBoot, "", seed);
    }
    run.wait_s(8.0);
  }

  testing::CompletedProcess report(std::vector<std::string> words) {
    words.insert(words.begin(),
                 {STROBE_PROGRAM, "report", folder / "today", "--key-file", folder / "lab.key"});
    return testing::run_program(std::move(words));
  }
};

TEST(ReportCommand, WritesOneFileAndSaysWhere) {
  const auto run = report({"--customer", "Courts & <Sons>"});
  testing::check_prints(run, {"report.html"});
  const auto parsed = report_test::parse_html(read_text(folder / "today/report.html"));
  CHECK_TEXT(parsed.well_formed, parsed.problem.c_str());
  for (const char* text : {"Lab", "Courts & <Sons>", "3 of 3 shots counted", "<b>new</b>", "End of report "})
    STRCMP_CONTAINS(text, parsed.text.c_str());
}

TEST(ReportCommand, GivesTheSameBytesEachTime) {
  testing::check_prints(report({"--out", folder / "a.html"}), {"a.html"});
  testing::check_prints(report({"--out", folder / "b.html"}), {"b.html"});
  CHECK(read_text(folder / "a.html") == read_text(folder / "b.html"));
}

TEST(ReportCommand, IsTheSameHoweverItsFolderIsNamed) {
  // Its contents are of no interest here, but that they are found.
  fs::create_directory(folder / "today/photographs");
  fs::copy_file(fs::path(STROBE_TEST_DATA) / "images/colour8.png", folder / "today/photographs/shot-0001-a.png");
  testing::check_prints(report({"--out", folder / "whole.html"}), {"whole.html"});
  const std::string whole = read_text(folder / "whole.html");
  STRCMP_CONTAINS("data:image/jpeg", whole.c_str());
  for (const auto& [from, name] : std::map<std::string, std::string>{
           {".", "today"}, {"bin", "../today/"}, {"today", "."}, {"today/photographs", ".."}}) {
    fs::create_directories(folder / "bin");
    const auto run = testing::run_program({"/bin/sh", "-c", "cd \"$0\" && exec \"$@\"", folder / from,
                                           STROBE_PROGRAM, "report", name, "--key-file", folder / "lab.key", "--out",
                                           folder / "relative.html"});
    testing::check_prints(run, {"relative.html"});
    CHECK_TEXT(read_text(folder / "relative.html") == whole, name.c_str());
  }
}

TEST(ReportCommand, TellsTheWholeReportAsOneObject) {
  const json all = testing::json_of(report({"--json", "--limit", "e=0.5..1", "--decision-rule", "simple"}));
  LONGS_EQUAL(16, all["report"]["id"].get<std::string>().size());
  LONGS_EQUAL(3, all["sections"]["photographs"]["shots"].size());
  CHECK_EQUAL(
      std::string("conforms"),
      all["sections"]["conformity"]["tables"]["limits"]["rows"][0]["conformity"]["text"].get<std::string>());
  const json& e = all["sections"]["results"]["tables"]["uncertainty_unnamed"]["rows"][6];
  CHECK_EQUAL(std::string("restitution e"), e["quantity"]["text"].get<std::string>());
  CHECK(e["expanded_uncertainty"]["number"].get<double>() > 0.0);
  CHECK_FALSE(fs::exists(folder / "today/report.html"));
}

TEST(ReportCommand, RefusesWhatItCannotUseInOneLine) {
  struct Case {
    std::vector<std::string> words;
    const char* named;
  };
  const std::vector<Case> cases{{{"--limit", "speed=1..2"}, "no such quantity"},
                                {{"--limit", "e=2..1"}, "above the largest"},
                                {{"--received", "yesterday"}, "--received must be a date, such as 2026-11-21"},
                                {{"--decision-rule", "lenient"}, "lenient"},
                                {{folder / "absent"}, "absent"},
                                {{"--out", "x.pdf"}, "--out x.pdf: a PDF is written with --pdf"},
                                {{"--rig", folder / "absent.toml"}, "absent.toml"}};
  for (const Case& each : cases) {
    const auto refused = report(each.words);
    LONGS_EQUAL_TEXT(2, refused.status->code, each.named);
    STRCMP_CONTAINS(each.named, refused.err.c_str());
    LONGS_EQUAL_TEXT(1, std::count(refused.err.begin(), refused.err.end(), '\n'), refused.err.c_str());
    CHECK_EQUAL(std::string(), refused.out);
  }
}

TEST(ReportCommand, SaysWhichProgramsPrintAPdfWhereNoneIsThere) {
  const auto refused = testing::run_program(
      {STROBE_PROGRAM, "report", folder / "today", "--key-file", folder / "lab.key", "--pdf"},
      {{"PATH", folder.path()}});
  LONGS_EQUAL(1, refused.status->code);
  STRCMP_CONTAINS("apt-get install weasyprint", refused.err.c_str());
}

TEST(ReportCommand, PrintsAPdfByTheProgramThatIsThere) {
  // Stands for weasyprint, which is not on every machine: a document with the page's bytes.
  fs::create_directory(folder / "bin");
  testing::write_text(folder / "bin/weasyprint",
                      "#!/bin/sh\n{ echo '%PDF-1.7'; echo \"$SOURCE_DATE_EPOCH\"; "
                      "/bin/cat \"$1\"; echo '%%EOF'; } > \"$2\"\n");
  fs::permissions(folder / "bin/weasyprint", fs::perms::owner_all);
  const auto run = testing::run_program(
      {STROBE_PROGRAM, "report", folder / "today", "--key-file", folder / "lab.key", "--pdf"},
      {{"PATH", folder / "bin"}});
  testing::check_prints(run, {"report.html", "report.pdf"});
  const std::string pdf = read_text(folder / "today/report.pdf");
  STRCMP_CONTAINS("1769817600", pdf.c_str());  // the shots' day, 2026-01-31
  STRCMP_CONTAINS("End of report", pdf.c_str());
  const auto named = testing::run_program({STROBE_PROGRAM, "report", folder / "today", "--key-file",
                                           folder / "lab.key", "--pdf", "--out", folder / "x.pdf"},
                                          {{"PATH", folder / "bin"}});
  testing::check_prints(named, {"x.html", "x.pdf"});
  CHECK(read_text(folder / "x.pdf") == pdf);
  CHECK(read_text(folder / "x.html") == read_text(folder / "today/report.html"));
  for (const auto& entry : fs::directory_iterator(folder / "today"))
    CHECK_TEXT(entry.path().filename().string().rfind(".printing", 0) != 0, entry.path().c_str());
}
