#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <sys/resource.h>
#include <vector>

#include "host/archive/read_session.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/batch/batch_row.hpp"
#include "host/batch/batch_run.hpp"
#include "host/batch/batch_tables.hpp"
#include "host/session/shot_table.hpp"
#include "tests/host/archive/written_session.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using host::BatchJournal;
using host::BatchManifest;
using testing::TemporaryFolder;
using testing::write_text;

std::vector<std::string> names_of(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const auto& session : host::batch_sessions(paths)) names.push_back(session.name);
  return names;
}

}  // namespace

TEST_GROUP(BatchJournalTest) { TemporaryFolder folder; };

TEST(BatchJournalTest, KeepsRowsAndHidesNoneBehindATornOne) {
  {
    auto journal = BatchJournal::open(folder.path(), "done.jsonl");
    CHECK_TRUE((*journal)->add("k1", {"a,\"b\"", true}, {}).has_value());
  }
  write_text(folder / "done.jsonl", testing::read_text(folder / "done.jsonl") + "{\"key\":\"k2\",\"resu");
  {
    auto journal = BatchJournal::open(folder.path(), "done.jsonl");
    CHECK_FALSE((*journal)->find("k2").has_value());
    CHECK_TRUE((*journal)->add("k3", {"c", false}, {}).has_value());
  }
  const auto journal = BatchJournal::open(folder.path(), "done.jsonl");
  CHECK_EQUAL("a,\"b\"", (*journal)->find("k1")->results);
  CHECK_TRUE((*journal)->find("k1")->failed);
  CHECK_EQUAL("c", (*journal)->find("k3")->results);
}

TEST(BatchJournalTest, KnowsTheRowsOfOtherPartsAndWritesNoneOfTheirs) {
  const std::string other = "{\"key\":\"k\",\"results\":\"r\"}\n{\"key\":\"torn";
  write_text(folder / "done-1-of-2.jsonl", other);
  const auto journal = BatchJournal::open(folder.path(), "done-2-of-2.jsonl");
  CHECK_EQUAL("r", (*journal)->find("k")->results);
  CHECK_EQUAL(other, testing::read_text(folder / "done-1-of-2.jsonl"));
}

TEST(BatchJournalTest, IsOpenOnce) {
  const auto journal = BatchJournal::open(folder.path(), "done.jsonl");
  CHECK_TRUE(journal.has_value());
  const auto second = BatchJournal::open(folder.path(), "done.jsonl");
  CHECK_EQUAL((folder / "done.jsonl").string() + ": another batch is writing it", second.error().message);
}

TEST(BatchJournalTest, HashesAPhotographAgainOnlyIfItChanged) {
  const auto picture = folder / "picture.tif";
  write_text(picture, "one");
  host::PhotographStamp known;
  {
    auto journal = BatchJournal::open(folder.path(), "done.jsonl");
    known = *(*journal)->stamp(picture);
    known.hash = "told";  // so that it shows which was taken
    CHECK_TRUE((*journal)->add("k", {"r", false}, known).has_value());
  }
  const auto journal = BatchJournal::open(folder.path(), "done.jsonl");
  CHECK_EQUAL("told", (*journal)->stamp(picture)->hash);
  write_text(picture, "three");
  CHECK(known.hash != (*journal)->stamp(picture)->hash);
  CHECK_FALSE((*journal)->stamp(folder / "none.tif").has_value());
}

TEST_GROUP(BatchTables) { TemporaryFolder folder; };

TEST(BatchTables, NameSessionsByTheirFoldersAndSoThatNoneIsMistakenForAnother) {
  CHECK_EQUAL((std::vector<std::string>{"a", "b"}), names_of({"x/a", "x/b/", "x/./a"}));
  const auto names = names_of({"x/a", "y/a", "z/results"});
  LONGS_EQUAL(3, names.size());
  CHECK(names[0] != names[1]);
  CHECK(names[0].starts_with("a-") && names[2].starts_with("results-"));
}

TEST(BatchTables, MergesByNameAndRefusesTablesOfAnotherBatch) {
  CHECK_TRUE(host::write_manifest(folder.path(), {"id2", {"b", "a"}}).has_value());
  CHECK_TRUE(host::write_session_table(folder.path(), "b", "2,id2\n").has_value());
  CHECK_TRUE(host::write_session_table(folder.path(), "a", "1,id1\n").has_value());
  CHECK_EQUAL("1 of 2 sessions are not finished: a",
              host::merge_tables({folder.path()}, folder.path()).error().message);
  CHECK_TRUE(host::write_session_table(folder.path(), "a", "1,id2\n").has_value());
  CHECK_EQUAL(2, host::merge_tables({folder.path()}, folder.path()).value());
  const std::string table = testing::read_text(folder / "results.csv");
  CHECK_EQUAL("1,id2\n2,id2\n", table.substr(table.find('\n') + 1));
}

TEST(BatchTables, MergesNoFoldersOfDifferentBatches) {
  TemporaryFolder other;
  CHECK_TRUE(host::write_manifest(folder.path(), {"id1", {"a"}}).has_value());
  CHECK_TRUE(host::write_manifest(other.path(), {"id2", {"a"}}).has_value());
  CHECK_FALSE(host::merge_tables({folder.path(), other.path()}, folder.path()).has_value());
  write_text(folder / "batch.json", "{");
  CHECK_FALSE(host::merge_tables({folder.path()}, folder.path()).has_value());
}

// A batch over sessions whose frames are stored: threads, stops and full disks, without the digitizer's time.
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
          host::results_line(shot).c_str(),
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
