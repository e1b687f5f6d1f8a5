// A batch over sessions whose frames are stored: threads, stops and full disks, without the digitizer's time.
#include "host/batch/batch_run.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/archive/read_session.hpp"
#include "host/archive/results_table.hpp"
#include "host/session/results_csv.hpp"
#include "tests/host/archive/written_session.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using host::BatchJournal;
using host::BatchProgress;
using host::BatchRun;
using host::BatchSession;
using host_test::WrittenRun;
using testing::TemporaryFolder;
namespace fs = std::filesystem;

constexpr int kSessions = 3, kShots = 4;  // of each

/// As a full disk: files of this process grow no further.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit less{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &less);
  }
  ~FileSizeLimit() { lift(); }
  void lift() const { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

}  // namespace

TEST_GROUP(BatchRun) {
  TemporaryFolder folder;
  host::BatchSettings settings;
  std::vector<BatchSession> sessions;

  void setup() override {
    settings.version = "1";
    settings.stored_frames = true;
    const auto key = authentication::Key::random();
    for (int i = 0; i < kSessions; ++i) {
      const fs::path session = folder / fmt::format("session{}", i);
      WrittenRun run(session, key, 500 + i, 3600 * i);
      run.heartbeat();
      for (int shot = 1; shot <= kShots; ++shot) run.shot(shot);
      sessions.push_back({session, session.filename()});
    }
  }

  Result<BatchProgress> run_batch(const fs::path& out, int jobs, int stop_after = 1000) {
    fs::create_directories(out);
    auto journal = BatchJournal::open(out, "done.jsonl");
    if (!journal) return tl::unexpected(journal.error());
    BatchRun* running = nullptr;
    BatchRun batch(settings, "id", out, **journal,
                   [&](const host::FinishedRow&, const BatchProgress& progress) {
                     if (progress.rows >= stop_after) running->stop();
                   });
    running = &batch;
    return batch.run(sessions, jobs);
  }
  std::string tables(const fs::path& out) {
    std::string all;
    for (const BatchSession& session : sessions) all += testing::read_text(out / (session.name + ".csv"));
    return all;
  }
};

TEST(BatchRun, GivesTheSameTablesByAnyNumberOfThreads) {
  const auto one = run_batch(folder / "one", 1), four = run_batch(folder / "four", 4);
  CHECK_EQUAL(kSessions * kShots, one->rows);
  CHECK_EQUAL(kSessions, four->sessions);
  CHECK_EQUAL(0, four->failed);
  CHECK_EQUAL(tables(folder / "one"), tables(folder / "four"));
}

TEST(BatchRun, GivesTheRowsThatTheSessionsThemselvesHave) {
  CHECK_TRUE(run_batch(folder / "out", 2).has_value());
  for (const BatchSession& session : sessions) {
    const auto stored = host::read_session(session.path);
    LONGS_EQUAL(kShots, stored->shots.size());
    const std::string table = testing::read_text(folder / "out" / (session.name + ".csv"));
    for (const auto& shot : stored->shots)
      STRCMP_CONTAINS(
          host::results_line(shot.result, shot.utc, shot.name, host::digitization_word(shot)).c_str(),
          table.c_str());
  }
}

TEST(BatchRun, StopsWhenToldAndGoesOnWithWhatIsLeft) {
  const auto stopped = run_batch(folder / "out", 1, 3);
  CHECK_EQUAL(3, stopped->rows);
  CHECK_EQUAL(0, stopped->sessions);
  CHECK_FALSE(fs::exists(folder / "out/session0.csv"));
  const auto rest = run_batch(folder / "out", 2);
  CHECK_EQUAL(kSessions * kShots, rest->rows);
  CHECK_EQUAL(kSessions * kShots - 3, rest->measured);
  CHECK_TRUE(run_batch(folder / "whole", 1).has_value());
  CHECK_EQUAL(tables(folder / "whole"), tables(folder / "out"));
}

TEST(BatchRun, MeasuresAgainWhatDependsOnAnotherVersion) {
  CHECK_EQUAL(kSessions * kShots, run_batch(folder / "out", 1)->measured);
  CHECK_EQUAL(0, run_batch(folder / "out", 1)->measured);
  settings.version = "2";
  CHECK_EQUAL(kSessions * kShots, run_batch(folder / "out", 1)->measured);
}

TEST(BatchRun, EndsWithTheFileThatCannotBeWrittenAndGoesOnOnceItCan) {
  const FileSizeLimit limit(2500);  // some rows, and no table
  const auto ended = run_batch(folder / "out", 2);
  CHECK_FALSE(ended.has_value());
  CHECK_EQUAL((folder / "out/done.jsonl").string() + ": File too large", ended.error().message);
  limit.lift();
  const auto rest = run_batch(folder / "out", 2);
  CHECK_EQUAL(kSessions * kShots, rest->rows);
  CHECK(rest->measured < rest->rows);  // those that were stored stay
  CHECK_TRUE(run_batch(folder / "whole", 1).has_value());
  CHECK_EQUAL(tables(folder / "whole"), tables(folder / "out"));
}

TEST(BatchRun, TellsWhatIsMissingOfASession) {
  for (const auto& entry : fs::directory_iterator(sessions[1].path))
    if (entry.path().extension() == ".lcmlog")
      testing::write_text(entry.path(), testing::read_text(entry.path()) + "torn");
  fs::remove_all(sessions[2].path);
  const auto told = run_batch(folder / "out", 2);
  CHECK_EQUAL(1, told->unread_sessions);
  CHECK_EQUAL(kSessions, told->sessions);
  STRCMP_CONTAINS("session not read: ", testing::read_text(folder / "out/session2.csv").c_str());
  CHECK_TRUE(fs::exists(folder / "out/session1.remarks.txt"));
}
