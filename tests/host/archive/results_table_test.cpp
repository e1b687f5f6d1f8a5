// results.csv made anew from a session.
#include "host/archive/results_table.hpp"

#include <filesystem>
#include <string>
#include <vector>

#include "host/session/data_dictionary.hpp"
#include "host/session/results_csv.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using host::StoredShot;
using testing::read_text;
using testing::write_text;

constexpr const char* kUtc = "2026-01-31T09:30:00.000Z";

StoredShot shot(int id) {
  StoredShot stored;
  stored.key = {0x4d, id};
  stored.name = std::to_string(id);
  stored.utc = kUtc;
  stored.result.boot_id = 0x4d;
  stored.result.shot_id = id;
  stored.result.readout.value[reduction::Quantity::e] = 0.1 * id;
  stored.result.readout.method = "best";
  stored.result.frame.emplace().source = "auto";
  stored.digitizations.push_back({*stored.result.frame, false, kUtc, "", {}, {}});
  return stored;
}

/// As fire writes it, one after the other.
std::string written(const std::filesystem::path& file, const std::vector<StoredShot>& shots) {
  for (const StoredShot& each : shots)
    CHECK_TRUE(host::ResultsCsv::open(file)->add(each.result, each.utc).has_value());
  return read_text(file);
}

std::string row(const StoredShot& shot) {
  return host::results_line(shot.result, shot.utc, shot.name, digitization_word(shot)) + "\n";
}

}  // namespace

TEST_GROUP(ResultsMadeAnew) {
  testing::TemporaryFolder folder;
  host::StoredSession session;

  void setup() override {
    session.folder = folder.path();
    for (const int id : {1, 2, 3}) session.shots.push_back(shot(id));
  }
};

TEST(ResultsMadeAnew, AreTheBytesThatFireWrote) {
  const std::string before = written(folder / "results.csv", session.shots);
  CHECK_EQUAL(before, host::results_table(session, host::parse_results(before)));
  CHECK_TRUE(host::rebuild_results(session, folder / "results.csv").has_value());
  CHECK_EQUAL(before, read_text(folder / "results.csv"));
  CHECK_EQUAL(before, host::results_table(session, {}));
  STRCMP_CONTAINS("\"digitization\"", read_text(folder / "results.csv-metadata.json").c_str());
}

TEST(ResultsMadeAnew, HaveTheRowsThatWereMissingEachOnce) {
  const std::string header = host::results_header() + "\n";
  const std::string all = header + row(session.shots[0]) + row(session.shots[1]) + row(session.shots[2]);
  for (const std::string& lost :
       {header + row(session.shots[2]), header + row(session.shots[0]) + row(session.shots[0]),
        header + row(session.shots[1]) + "2026-01-31T09", header.substr(0, 20), std::string()})
    CHECK_EQUAL(all, host::results_table(session, host::parse_results(lost)));
}

TEST(ResultsMadeAnew, KeepTheOrderInWhichTheResultsCame) {
  const std::string header = host::results_header() + "\n";
  const std::string before = header + row(session.shots[2]) + row(session.shots[0]);
  CHECK_EQUAL(header + row(session.shots[2]) + row(session.shots[0]) + row(session.shots[1]),
              host::results_table(session, host::parse_results(before)));
}

TEST(ResultsMadeAnew, KeepRowsThatTheSessionDoesNotTellOf) {
  const StoredShot other = shot(9);
  // A version's that had neither of the last two columns.
  std::string shorter = row(other);
  shorter.erase(shorter.size() - std::string(",auto,9\n").size());
  const std::string table = host::results_table(
      session, host::parse_results(host::earlier_results_headers().front() + "\n" + shorter + "\n"));
  STRCMP_CONTAINS((shorter + ",,\n").c_str(), table.c_str());
  STRCMP_CONTAINS(row(session.shots[0]).c_str(), table.c_str());
}

TEST(ResultsMadeAnew, SayWhoMeasured) {
  StoredShot& corrected = session.shots[1];
  corrected.digitizations.push_back(
      {*corrected.result.frame, true, kUtc, "ann@lab", "digitizations/x.json", {}});
  session.shots[2].digitizations.clear();
  session.shots[2].result.frame.reset();
  const std::string table = host::results_table(session, {});
  for (const char* words : {",auto,1\n", ",corrected,2\n", ",,3\n"}) STRCMP_CONTAINS(words, table.c_str());
}
