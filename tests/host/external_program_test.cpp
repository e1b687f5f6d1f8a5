#include "host/external/program.hpp"

#include <cstdlib>

#include "common/config/files.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

namespace fs = std::filesystem;
using namespace strobe;
using external::run_program;
using external::WorkFolder;

TEST_GROUP(ExternalProgram) {
  testing::TemporaryFolder folder;

  Result<void> shell(const WorkFolder& work, const std::string& script,
                     std::vector<std::string> environment = {}) {
    return run_program({"/bin/sh", "-c", script}, work, std::move(environment));
  }
};

TEST(ExternalProgram, IsFoundInThePath) {
  CHECK_TRUE(external::find_program("sh").has_value());
  CHECK_FALSE(external::find_program("no such program").has_value());
}

TEST(ExternalProgram, RunsInAFolderThatGoesWithItsObject) {
  fs::path inside;
  {
    const auto work = WorkFolder::make(folder / "new");
    CHECK_TRUE(work.has_value());
    inside = work->path();
    CHECK_TRUE(shell(*work, "echo made > file").has_value());
    CHECK_EQUAL("made\n", testing::read_text(inside / "file"));
    CHECK_EQUAL((folder / "new").string(), inside.parent_path().string());
  }
  CHECK_FALSE(fs::exists(inside));
}

TEST(ExternalProgram, ThatFailsIsNamedWithItsLastMessage) {
  const auto work = WorkFolder::make(folder.path());
  const auto ran = shell(*work, "echo first; echo 'what is wrong' >&2; echo; exit 3");
  CHECK_FALSE(ran.has_value());
  CHECK_EQUAL("/bin/sh: what is wrong", ran.error().message);
}

TEST(ExternalProgram, ThatTakesTooLongIsEnded) {
  const auto work = WorkFolder::make(folder.path());
  const auto ran = run_program({"/bin/sh", "-c", "exec sleep 1000"}, *work, {}, std::chrono::milliseconds(50));
  CHECK_EQUAL("/bin/sh: takes too long", ran.error().message);
  CHECK_TRUE(run_program({"/bin/sh", "-c", "exit 0"}, *work, {}, std::chrono::minutes(10)).has_value());
}

TEST(ExternalProgram, ThatIsNotThereIsNamed) {
  const auto work = WorkFolder::make(folder.path());
  const auto ran = run_program({"/no/such/program"}, *work);
  CHECK_EQUAL("/no/such/program: cannot be started: No such file or directory", ran.error().message);
}

TEST(ExternalProgram, GetsWhatIsGivenInPlaceOfThisProcesssEnvironment) {
  setenv("STROBE_TEST_GIVEN", "own", 1);
  const auto work = WorkFolder::make(folder.path());
  CHECK_TRUE(shell(*work, "echo $STROBE_TEST_GIVEN $HOME > seen", {"STROBE_TEST_GIVEN=given"}).has_value());
  unsetenv("STROBE_TEST_GIVEN");
  const char* home = std::getenv("HOME");
  CHECK_EQUAL("given" + (home ? " " + std::string(home) : "") + "\n",
              testing::read_text(work->path() / "seen"));
}
