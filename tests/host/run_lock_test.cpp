// One run at a time writes a session: told at once to who comes second, gone with its holder, out of strangers' reach.
#include "host/session/run_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "host/session/session_folder.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using host::RunLock;
namespace fs = std::filesystem;

constexpr WallTime kNow{milliseconds{1'769'851'800'123}};

/// A process that does something, tells that it is done, and stays until it is killed.
class Bystander {
 public:
  template <typename Act>
  explicit Bystander(Act act) {
    int told[2];
    if (::pipe(told) != 0) FAIL("no pipe");
    pid_ = ::fork();
    if (pid_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      const char good = act() ? 'y' : 'n';
      static_cast<void>(!::write(told[1], &good, 1));
      while (true) ::pause();
    }
    static_cast<void>(!::read(told[0], &said_, 1));
    ::close(told[0]);
    ::close(told[1]);
  }
  ~Bystander() { kill(); }
  bool did() const { return said_ == 'y'; }
  void kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = 0;
  char said_ = 'n';
};

bool holds(const fs::path& file) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  return fd >= 0 && ::flock(fd, LOCK_EX) == 0;
}

mode_t mode_of(const fs::path& file) {
  struct stat status {};
  return ::lstat(file.c_str(), &status) == 0 ? status.st_mode & 0777 : 0;
}

}  // namespace

TEST_GROUP(RunLock) {
  testing::TemporaryFolder place;
  fs::path session = place / "run1";
  fs::path file = session / "session.lock";

  Result<RunLock> take(const char* who = "bob@lab") { return RunLock::of_session(session, who, kNow); }
};

TEST(RunLock, WhoComesSecondIsToldAtOnceWhoseRunItIs) {
  Bystander first([this] { return (new Result<RunLock>(take("ann@lab")))->has_value(); });
  CHECK_TRUE(first.did());
  const auto second = take();
  CHECK_FALSE(second.has_value());
  CHECK_EQUAL(file.string() + ": in use by ann@lab, process " + std::to_string(first.pid()) +
                  ", since 2026-01-31T09:30:00.123Z",
              second.error().message);
}

TEST(RunLock, GoesWithItsHolderHoweverThatEnds) {
  Bystander first([this] { return (new Result<RunLock>(take("ann@lab")))->has_value(); });
  CHECK_FALSE(take().has_value());
  first.kill();
  CHECK_TRUE(fs::exists(file));
  const auto next = take();
  CHECK_TRUE(next.has_value());
  CHECK_EQUAL("bob@lab, process " + std::to_string(::getpid()) + ", since 2026-01-31T09:30:00.123Z\n",
              testing::read_text(file));
}

TEST(RunLock, LeavesNothingBehind) {
  {
    const auto lock = take();
    CHECK_TRUE(lock.has_value());
    CHECK_FALSE(take().has_value());  // of one process, too
    LONGS_EQUAL(0600, mode_of(file));
  }
  CHECK_FALSE(fs::exists(session));  // it was made for the lock
  fs::create_directories(session);
  CHECK_TRUE(take().has_value());
  CHECK_TRUE(fs::is_empty(session));
}

TEST(RunLock, AFileThatOthersCanOpenIsReplaced) {
  fs::create_directories(session);
  testing::write_text(file, "copied from elsewhere\n");
  ::chmod(file.c_str(), 0644);
  const Bystander stranger([this] { return holds(file); });
  CHECK_TRUE(stranger.did());
  const auto lock = take();
  CHECK_TRUE(lock.has_value());
  LONGS_EQUAL(0600, mode_of(file));
  CHECK_FALSE(take().has_value());
}

TEST(RunLock, WhatIsNoFileOfOursIsNotFollowed) {
  fs::create_directories(session);
  fs::create_symlink(place / "elsewhere", file);
  STRCMP_CONTAINS("session.lock: cannot be opened", take().error().message.c_str());
  CHECK_FALSE(fs::exists(place / "elsewhere"));
  fs::remove(file);
  fs::create_directory(file);
  STRCMP_CONTAINS("session.lock: cannot be opened", take().error().message.c_str());
}

TEST(RunLock, WhateverTheFileSaysIsOneLine) {
  fs::create_directories(session);
  testing::write_text(file, std::string("\x1b[2J\n", 5) + std::string(1000, 'x'));
  ::chmod(file.c_str(), 0600);
  const Bystander other([this] { return holds(file); });
  CHECK_TRUE(other.did());
  CHECK_EQUAL(file.string() + ": in use by [2J" + std::string(195, 'x'), take().error().message);
}

/// What a stranger may open he may lock: the host's loop must not wait for him.
TEST(RunLock, NobodysLockOnTheSessionsFilesHoldsUpWhatIsWritten) {
  auto folder = host::SessionFolder::open(session, "20260131T093000Z", "rig = \"bench\"\n", "");
  CHECK_TRUE(folder.has_value());
  (*folder)->add(host::RunRecord{});
  const Bystander stranger([this] {
    bool good = true;
    for (const auto& entry : fs::directory_iterator(session)) good = holds(entry.path()) && good;
    return good;
  });
  CHECK_TRUE(stranger.did());
  ::alarm(20);  // a blocked write does not come back
  strobe_msgs::shot_t shot{};
  shot.flashes.resize(1);
  (*folder)->add(shot);
  (*folder)->add_text("a line\n");
  (*folder)->add(host::Shot{}, "2026-01-31T09:30:00.000Z");
  (*folder)->add(host::RunRecord{});
  (*folder)->log("CHANNEL", {}, kNow);
  (*folder)->tend();
  (*folder)->sync();
  ::alarm(0);
  CHECK_TRUE((*folder)->take_failures().empty());
  CHECK_EQUAL("a line\n", testing::read_text(session / "shots.txt"));
}
