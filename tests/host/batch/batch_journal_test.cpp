#include "host/batch/batch_journal.hpp"

#include <filesystem>
#include <string>

#include "host/batch/batch_tables.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

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
