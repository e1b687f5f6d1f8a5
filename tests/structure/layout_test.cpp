// The top level of the repository is fixed: what is new finds its place in one of the folders.
#include <filesystem>
#include <set>
#include <string>

#include "tests/structure/source_tree.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::structure;

TEST_GROUP(Layout){};

TEST(Layout, TheTopLevelHoldsTheAgreedEntriesOnly) {
  const std::set<std::string> allowed{"CMakeLists.txt", "CMakePresets.json", "README.md", "LICENSE",
                                      "common",         "firmware",          "host",      "sim",
                                      "tests"};
  const std::set<std::string> made_by_tools{"build", "sessions",
                                            "compile_commands.json"};  // git ignores them
  for (const auto& entry : std::filesystem::directory_iterator(repository_root())) {
    const std::string name = entry.path().filename().string();
    CHECK_TEXT(name[0] == '.' || allowed.count(name) != 0 || made_by_tools.count(name) != 0, name.c_str());
  }
}

TEST(Layout, ScriptsThatPeopleRunAreExecutable) {
  for (const char* script :
       {"tests/run", "tests/install-packages", "tests/fuzz/run-long", "sim/demo", ".ci/run"}) {
    std::error_code error;
    const auto status = std::filesystem::status(repository_root() / script, error);
    const auto execute = std::filesystem::perms::owner_exec;
    CHECK_TEXT(std::filesystem::is_regular_file(status) && (status.permissions() & execute) == execute,
               script);
  }
}

TEST(Layout, FilesHaveOneDutyAndAReadableLength) {
  for (const SourceFile& file : cpp_files())
    if (top_folder(file.path) != "tests")
      CHECK_TEXT(file.lines.size() <= 450, (file.path + " is longer than 450 lines").c_str());
}

TEST(Layout, EveryHeaderIsIncludedOnce) {
  for (const SourceFile& file : cpp_files()) {
    if (std::filesystem::path(file.path).extension() != ".hpp") continue;
    bool guarded = false;
    for (const std::string& line : file.lines) guarded = guarded || line == "#pragma once";
    CHECK_TEXT(guarded, (file.path + " lacks #pragma once").c_str());
  }
}
