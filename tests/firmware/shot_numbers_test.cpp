#include "firmware/publisher/shot_numbers.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <string>

#include "firmware/publisher/journal_folder.hpp"
#include "tests/firmware/journal_messages.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {

constexpr std::int32_t kAtOnce = ShotNumbers::kAtOnce;
std::string calls;  ///< that decide on what a power cut leaves

}  // namespace

/// Stand in for the C library's.
extern "C" int fsync(int fd) {
  struct stat file {};
  fstat(fd, &file);
  calls += S_ISDIR(file.st_mode) ? "sync the folder; " : "sync the file; ";
  return static_cast<int>(syscall(SYS_fsync, fd));
}
extern "C" int rename(const char* from, const char* to) noexcept {
  calls += "rename; ";
  return static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

TEST_GROUP(ShotNumbers) {
  strobe::testing::TemporaryFolder folder;
  std::filesystem::path session = folder / "session";

  std::int32_t stored() const { return ShotNumbers::read(session).value_or(-1); }
};

TEST(ShotNumbers, AreOnTheDiskBeforeTheyMayBeUsed) {
  ShotNumbers numbers(session, 0);
  CHECK_EQUAL(0, numbers.last_before());
  CHECK_EQUAL(0, numbers.limit());
  calls.clear();
  CHECK_TRUE(numbers.set_aside(0).has_value());
  CHECK_EQUAL("sync the file; rename; sync the folder; ", calls);
  CHECK_EQUAL(kAtOnce, numbers.limit());
  CHECK_EQUAL(kAtOnce, stored());
}

TEST(ShotNumbers, AreNeverUsedTwiceWhateverIsLostInThePowerCut) {
  std::int32_t before = 0;
  for (int start = 0; start < 5; ++start) {
    ShotNumbers numbers(session, 0);  // the journals are lost
    CHECK(numbers.last_before() >= before);
    CHECK_TRUE(numbers.set_aside(numbers.last_before()).has_value());
    for (std::int32_t shot = numbers.last_before() + 1; shot <= numbers.last_before() + 20; ++shot) {
      CHECK(shot > before && shot <= numbers.limit());
      before = shot;
      CHECK_TRUE(numbers.set_aside(shot).has_value());
    }
  }
}

TEST(ShotNumbers, AreSetAsideOnceForManyShots) {
  ShotNumbers numbers(session, 0);
  calls.clear();
  for (std::int32_t shot = 0; shot <= kAtOnce / 2; ++shot) CHECK_TRUE(numbers.set_aside(shot).has_value());
  CHECK_EQUAL("sync the file; rename; sync the folder; ", calls);
}

TEST(ShotNumbers, GoOnWithoutAGapAfterAnOrderlyEnd) {
  ShotNumbers numbers(session, 0);
  CHECK_TRUE(numbers.set_aside(0).has_value());
  CHECK_TRUE(numbers.give_back(3).has_value());
  CHECK_EQUAL(3, ShotNumbers(session, 3).last_before());
}

TEST(ShotNumbers, AreNotGivenBackOnceAnotherStartHasSetItsOwnAside) {
  ShotNumbers old(session, 0);
  CHECK_TRUE(old.set_aside(0).has_value());
  ShotNumbers fresh(session, 0);
  CHECK_TRUE(fresh.set_aside(fresh.last_before()).has_value());
  CHECK_TRUE(old.give_back(3).has_value());
  CHECK_EQUAL(2 * kAtOnce, stored());
}

TEST(ShotNumbers, FollowTheJournalsWhereTheFileIsMissingOrDamaged) {
  std::filesystem::create_directories(session);
  CHECK_EQUAL(0, ShotNumbers(session, 0).last_before());
  CHECK_EQUAL(7 + kAtOnce, ShotNumbers(session, 7).last_before());
  for (const std::string text : {"", "7", "-7\n", "7\n\n", "x\n", "99999999999\n", "2000000001\n", " 7\n"}) {
    strobe::testing::write_text(session / "shot-numbers", text);
    CHECK_EQUAL(7 + kAtOnce, ShotNumbers(session, 7).last_before());
  }
  strobe::testing::write_text(session / "shot-numbers", "5\n");
  CHECK_EQUAL(7, ShotNumbers(session, 7).last_before());  // another session's journals were copied here
}

TEST(ShotNumbers, SayWhyTheyCannotBeSetAsideAndLetTheOldOnesBeUsedUp) {
  ShotNumbers numbers(session, 0);
  CHECK_TRUE(numbers.set_aside(0).has_value());
  auto* const before = signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit full{0, limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  const auto failed = numbers.set_aside(12);
  setrlimit(RLIMIT_FSIZE, &limit);
  signal(SIGXFSZ, before);
  CHECK_FALSE(failed.has_value());
  STRCMP_CONTAINS("shot-numbers: no number can be set aside for a shot: File too large",
                  failed.error().message.c_str());
  CHECK_EQUAL(kAtOnce, numbers.limit());
  CHECK_EQUAL(kAtOnce, stored());
  CHECK_TRUE(numbers.set_aside(12).has_value());
  CHECK_EQUAL(12 + kAtOnce, stored());
}

TEST(ShotNumbers, MakeOldJournalsSuperfluousAtAStart) {
  using namespace std::chrono_literals;
  const auto now = std::filesystem::file_time_type::clock::now();
  for (std::int64_t boot = 1; boot <= 20; ++boot) {
    auto journal = Journal::create(session, boot);
    CHECK_TRUE(
        journal->append({journal_test::event(1, static_cast<std::int32_t>(100 - boot))}, boot).has_value());
    std::filesystem::last_write_time(journal->path(), now - 1h * (20 - boot));
  }
  CHECK_EQUAL(99, repair_journals(session).last_shot_id);
  ShotNumbers numbers(session, 99);
  CHECK_TRUE(numbers.set_aside(numbers.last_before()).has_value());
  CHECK_EQUAL(95, repair_journals(session).last_shot_id);  // of the latest sixteen
  CHECK_EQUAL(99 + 2 * kAtOnce, ShotNumbers(session, 95).last_before());
}
