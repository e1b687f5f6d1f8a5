// The shipped programs with the rig file that `strobe-sim run --write-rig` writes, and without any.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace std::chrono_literals;
using namespace strobe::testing;

std::string program(const char* name) { return std::string(STROBE_BUILD_DIR) + "/bin/" + name; }

std::vector<std::string> scene_names() {
  const auto listed = run_process({{program("strobe-sim"), "scenes", "--json"}}, 60s);
  std::vector<std::string> names;
  std::istringstream lines(listed.out);
  for (std::string line; std::getline(lines, line);)
    names.push_back(nlohmann::json::parse(line).at("scene").get<std::string>());
  CHECK(names.size() > 50);
  return names;
}

}  // namespace

TEST_GROUP(WriteRig) {
  TemporaryFolder folder;

  CompletedProcess run(std::vector<std::string> words) {
    words[0] = program(words[0].c_str());
    return run_process({words, {{"HOME", folder.path()}}, folder.path(), {}}, 60s);
  }
  /// Fails with what was said.
  void check_done(const CompletedProcess& finished, const std::string& what) {
    CHECK_TEXT(finished.status == ExitStatus({0, 0}), (what + ": " + finished.out + finished.err).c_str());
  }
};

TEST(WriteRig, StrobedAndTheHostTakeTheFileOfEveryScene) {
  for (const std::string& name : scene_names()) {
    const std::string file = name + "/rig.toml";
    check_done(run({"strobe-sim", "run", "--scene", name, "--no-digitizer", "--photographs", name + "/photos",
                    "--write-rig", file, "--", program("strobed"), "--check", "--config", file, "--session",
                    name + "/session", "--allow-no-rt"}),
               name);
    check_done(run({"strobe", "key", "--rig", file}), name);
  }
}

TEST(WriteRig, WithoutACommandOnlyTheFileIsWritten) {
  check_done(run({"strobe-sim", "run", "--scene", "zero_23", "--write-rig", "rig.toml"}), "once");
  check_done(run({"strobe-sim", "run", "--scene", "zero_23", "--write-rig", "rig.toml"}), "again");
  const auto refused = run({"strobe-sim", "run", "--scene", "top_23", "--write-rig", "rig.toml"});
  CHECK_EQUAL(ExitStatus({2, 0}), refused.status);
  STRCMP_CONTAINS("rig.toml: is there already", refused.err.c_str());
}

TEST(WriteRig, StrobedTakesTheExampleWhereNoFileIsNamed) {
  const auto checked = run({"strobe-sim", "run", "--scene", "zero_23", "--no-digitizer", "--",
                            program("strobed"), "--check", "--session", "session", "--allow-no-rt"});
  check_done(checked, "strobed --check");
  STRCMP_CONTAINS("strobed: no --config given: taking the example ", checked.err.c_str());
  STRCMP_CONTAINS("share/strobe/rig.toml", checked.err.c_str());
}

TEST(WriteRig, TheExampleDrivesNothingWhereItsLinesAreNot) {
  for (const char* option : {"--safe", "--move-interrupts"}) {
    const auto refused = run({"strobed", option});
    CHECK_EQUAL(ExitStatus({2, 0}), refused.status);
    STRCMP_CONTAINS("--config is required", refused.err.c_str());
  }
  const auto elsewhere = run({"strobed", "--session", "session", "--allow-no-rt"});
  CHECK_EQUAL(ExitStatus({2, 0}), elsewhere.status);
  STRCMP_CONTAINS("gpiochip0", elsewhere.err.c_str());
}
