// Sessions over HTTP: lists, details, photographs, series and reports of folders as hosts write them.
#include "host/web/archive_routes.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/authentication/key_file.hpp"
#include "common/image/image_files.hpp"
#include "host/archive/read_session.hpp"
#include "tests/host/web/painted_session.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using nlohmann::ordered_json;
namespace fs = std::filesystem;
using host_test::WrittenRun;

/// Each file with its size and time of change.
std::string state_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    files[entry.path().string()] =
        entry.is_regular_file()
            ? fmt::format("{} {}", entry.file_size(), entry.last_write_time().time_since_epoch().count())
            : "";
  std::string text;
  for (const auto& [name, state] : files) text += name + " " + state + "\n";
  return text;
}

std::string utc(int second) { return fmt::format("2026-01-31T09:30:{:02}.000Z", second); }

}  // namespace

TEST_GROUP(ArchiveRoutes) {
  testing::TemporaryFolder place;
  fs::path sessions = place / "sessions";
  fs::path key_file = place / "lab.key";
  authentication::Key key = authentication::make_key_file(key_file).value().key;
  std::unique_ptr<web::Archive> archive;
  web::Router router;

  void setup() override {
    fs::create_directories(sessions);
    open("");
  }
  void open(const std::string& live) {
    archive =
        std::make_unique<web::Archive>(web::SessionStoreSettings{sessions, live, key_file.string(), "1.0"});
    router = {};
    add_archive_routes(router, *archive);
  }
  /// Of so many shots, each with its row.
  void write(const std::string& name, int shots, int second = 0) {
    WrittenRun run(sessions / name, key, 5, second);
    for (int shot = 1; shot <= shots; ++shot) add(run, sessions / name, shot);
  }
  void add(WrittenRun & run, const fs::path& folder, int shot) {
    run.shot(shot);
    const auto read = host::read_session(folder, {"", key_file.string(), {}}).value();
    run.folder().add(read.shots.back(), utc(shot));
  }
  /// Six shots: three on each, the second three with the ball's name, too.
  void write_on_two_surfaces(const std::string& name) {
    WrittenRun run(sessions / name, key, 5, 0);
    run.notes = {{"surface_name", "acrylic"}};
    for (int shot = 1; shot <= 3; ++shot) add(run, sessions / name, shot);
    run.notes = {{"surface_name", "cushion"}, {"ball_name", "ITF type 2"}};
    for (int shot = 4; shot <= 6; ++shot) add(run, sessions / name, shot);
  }
  web::Response ask(const std::string& path, std::map<std::string, std::string> query = {}) {
    web::Request request{"GET", "/api/v1" + path, std::move(query), {}, "", ""};
    return router.route(request);
  }
  ordered_json json(const std::string& path, std::map<std::string, std::string> query = {},
                    int status = 200) {
    const auto response = ask(path, std::move(query));
    LONGS_EQUAL_TEXT(status, response.status, response.body->c_str());
    return ordered_json::parse(*response.body);
  }
};

TEST(ArchiveRoutes, ListSessionsNewestFirst) {
  write("first", 1, 0);
  write("second", 2, 3600);
  fs::create_directories(sessions / "no session");
  fs::create_directories(place / "outside");
  fs::copy(sessions / "first", place / "outside", fs::copy_options::recursive);
  fs::create_directory_symlink(place / "outside", sessions / "link");
  {  // whose first run was later
    std::ofstream(sessions / "second" / "runs.jsonl")
        << "{\"utc\":\"2026-03-01T00:00:00.000Z\",\"host_id\":\"5\"}\n{torn";
  }
  const ordered_json list = json("/sessions");
  LONGS_EQUAL(2, list.size());
  CHECK_EQUAL("second", list[0]["id"].get<std::string>());
  CHECK_EQUAL("2026-03-01T00:00:00.000Z", list[0]["utc"].get<std::string>());
  LONGS_EQUAL(2, list[0]["shots"].get<int>());
  LONGS_EQUAL(2, list[0]["counted"].get<int>());
  CHECK_EQUAL("bench", list[0]["rig"].get<std::string>());
  CHECK_FALSE(list[0]["live"].get<bool>());
  json("/sessions/link/shots", {}, 404);
  json("/sessions/no session/shots", {}, 404);
  LONGS_EQUAL(0, archive->sessions.readings());
}

/// As somebody may have sent it: what the parsers cannot take, and what is too large to be a file of ours.
TEST(ArchiveRoutes, ListASessionThatCannotBeReadAsOne) {
  write("good", 1);
  write("keys", 1);
  write("lines", 1);
  std::string keys;
  for (int i = 0; i < 120'000; ++i) keys += "a.";
  testing::write_text(sessions / "keys" / "rig.toml", keys + "a = 1\n");
  testing::write_text(sessions / "lines" / "results.csv", "");
  fs::resize_file(sessions / "lines" / "results.csv", std::uintmax_t{1} << 40);
  testing::write_text(sessions / "good" / "runs.jsonl", std::string(1'000'000, '[') + "\n");
  const ordered_json list = json("/sessions");
  LONGS_EQUAL(3, list.size());
  std::map<std::string, std::string> problems;
  for (const auto& session : list)
    if (session["problem"].is_string())
      problems[session["id"].get<std::string>()] = session["problem"].get<std::string>();
  CHECK_EQUAL("", problems["good"]);
  CHECK_EQUAL("rig.toml:1: a key of more than 16 parts", problems["keys"]);
  STRCMP_CONTAINS("results.csv: a line is longer than 1 MB", problems["lines"].c_str());
  json("/sessions/keys/shots/1", {}, 409);
  json("/sessions/lines/shots/1", {}, 409);
  json("/sessions/lines/shots", {}, 409);
  LONGS_EQUAL(1, json("/sessions/keys/shots")["shots"].size());
  LONGS_EQUAL(1, json("/sessions/good/shots")["shots"].size());
}

TEST(ArchiveRoutes, NameSessionsWhateverTheirFoldersAreCalled) {
  const std::vector<std::string> names{"<b>\"&amp;", "100% sure", "bad\xff\xfeutf", "tab\there", "später"};
  for (const std::string& name : names) write(name, 1);
  const ordered_json list = json("/sessions");
  LONGS_EQUAL(names.size(), list.size());
  std::set<std::string> ids;
  for (const auto& session : list) {
    const auto id = session["id"].get<std::string>();
    ids.insert(id);
    LONGS_EQUAL(1, json("/sessions/" + id + "/shots")["shots"].size());
    CHECK_EQUAL(id, json("/sessions/" + id + "/shots")["shots"][0]["session"].get<std::string>());
  }
  CHECK_TRUE(ids ==
             (std::set<std::string>{"<b>\"&amp;", "100%25 sure", "bad%FF%FEutf", "tab%09here", "später"}));
}

TEST(ArchiveRoutes, ListShotsNewestFirstAPieceAtATime) {
  write("today", 5);
  const ordered_json first = json("/sessions/today/shots", {{"limit", "2"}});
  LONGS_EQUAL(2, first["shots"].size());
  CHECK_EQUAL("5", first["shots"][0]["name"].get<std::string>());
  CHECK_TRUE(first["more"].get<bool>());
  const ordered_json rest = json("/sessions/today/shots", {{"limit", "9"}, {"before", "4"}});
  LONGS_EQUAL(3, rest["shots"].size());
  CHECK_EQUAL("1", rest["shots"][2]["name"].get<std::string>());
  CHECK_FALSE(rest["more"].get<bool>());
  for (const char* limit : {"0", "-7", "x", "99999999999999999999"})
    CHECK_TRUE(json("/sessions/today/shots", {{"limit", limit}})["shots"].size() >= 1);
  json("/sessions/today/shots", {{"before", "77"}}, 404);
  LONGS_EQUAL(0, archive->sessions.readings());  // results.csv alone
}

TEST(ArchiveRoutes, TellAllOfAShotAndReadItsSessionOnce) {
  write("today", 3);
  const ordered_json shot = json("/sessions/today/shots/2");
  const ordered_json row = json("/sessions/today/shots", {{"before", "3"}, {"limit", "1"}})["shots"][0];
  for (const auto& [name, value] : row.items()) CHECK_EQUAL(value.dump(), shot[name].dump());
  CHECK_TRUE(shot["images"].size() > 8);
  CHECK_EQUAL(row["values"]["e"]["value"].dump(), shot["readout"]["e"].dump());
  CHECK_TRUE(shot["photograph"].is_null());
  json("/sessions/today/shots/3");
  json("/sessions/today/series");
  LONGS_EQUAL(1, archive->sessions.readings());
  for (const char* name : {"4", "0", "3/77", "x", "..", "%2e"})
    json("/sessions/today/shots/" + std::string(name), {}, 404);
  LONGS_EQUAL(1, archive->sessions.readings());
}

TEST(ArchiveRoutes, ReadASessionThatAHostIsWriting) {
  const fs::path folder = sessions / "today";
  WrittenRun run(folder, key, 5, 0);
  add(run, folder, 1);
  open("today");
  CHECK_TRUE(json("/sessions")[0]["live"].get<bool>());
  LONGS_EQUAL(1, json("/sessions/today/shots")["shots"].size());
  json("/sessions/today/shots/1");
  run.heartbeat();  // the log grows, but no shot is new
  json("/sessions/today/shots/1");
  LONGS_EQUAL(1, archive->sessions.readings());
  add(run, folder, 2);
  {  // a record that is not whole yet, of log and table
    std::ofstream(run.folder().log_path(), std::ios::app | std::ios::binary) << "\xed\xa1\xda\x01 torn";
    std::ofstream(folder / "results.csv", std::ios::app) << "2026-01-31T09:30:09.000Z,4d,3,";
  }
  const std::string before = state_of(sessions);
  LONGS_EQUAL(2, json("/sessions/today/shots")["shots"].size());
  CHECK_EQUAL("2", json("/sessions/today/shots/2")["name"].get<std::string>());
  LONGS_EQUAL(2, json("/sessions/today/series")["points"].size());
  LONGS_EQUAL(2, archive->sessions.readings());
  CHECK_EQUAL(before, state_of(sessions));
}

TEST(ArchiveRoutes, ShowTheNewestShotsOfTheirOwnProcessWithoutReadingLogs) {
  const fs::path folder = sessions / "today";
  {
    WrittenRun run(folder, key, 5, 0);
    add(run, folder, 1);
  }
  const auto session = host::read_session(folder, {"", key_file.string(), {}}).value();
  const host::Shot& stored = session.shots[0];
  open("today");
  web::LiveShots live(folder, stored.rig, [](std::int64_t host) { return host == 5; });
  archive->sessions.set_live_shots(&live);
  live.on_shot(*stored.summary);
  live.on_shot_result(stored);
  ordered_json shown = json("/sessions/today/shots/1");
  LONGS_EQUAL(0, archive->sessions.readings());
  archive->sessions.set_live_shots(nullptr);
  ordered_json read = json("/sessions/today/shots/1");
  LONGS_EQUAL(1, archive->sessions.readings());
  shown["digitizations"][0].erase("utc");  // of the log's frame, not of the row
  read["digitizations"][0].erase("utc");
  CHECK_TRUE(read == shown);
  // Many more push it out.
  archive->sessions.set_live_shots(&live);
  for (int id = 100; id < 200; ++id) {
    host::Shot other = stored;
    other.shot_id = id;
    live.on_shot_result(other);
  }
  CHECK_FALSE(live.find(stored.key()).has_value());
  CHECK_TRUE(live.find({stored.boot_id, 199}).has_value());
}

TEST(ArchiveRoutes, SendThePhotographScaledAndItsTag) {
  const fs::path folder = sessions / "today";
  {
    WrittenRun run(folder, key, 5, 0, web_test::painted_rig());
    web_test::add_painted_shot(run, folder, 1);
  }
  const auto size_of = [](const web::Response& response) {
    const auto raster = image::decode_jpeg(
        {reinterpret_cast<const unsigned char*>(response.body->data()), response.body->size()});
    CHECK_TRUE(raster.has_value());
    return std::pair(raster->width(), raster->height());
  };
  const web::Response small = ask("/sessions/today/shots/1/photograph", {{"width", "300"}});
  CHECK_EQUAL("image/jpeg", small.type);
  CHECK_TRUE(size_of(small) == std::pair(320, 187));
  const web::Response whole = ask("/sessions/today/shots/1/photograph");
  CHECK_TRUE(size_of(whole) == std::pair(web_test::kWidth_px, web_test::kHeight_px));
  CHECK_TRUE(small.etag != whole.etag && !small.etag.empty());
  CHECK_EQUAL(small.etag, ask("/sessions/today/shots/1/photograph", {{"width", "320"}}).etag);
  CHECK_EQUAL(whole.etag, ask("/sessions/today/shots/1/photograph", {{"width", "4000"}}).etag);
  const fs::path photograph = folder / "photographs" / "shot-0001-painted.tif";
  fs::rename(photograph, place / "secret.tif");
  fs::create_symlink(place / "secret.tif", photograph);
  LONGS_EQUAL(404, ask("/sessions/today/shots/1/photograph", {{"width", "320"}}).status);
}

TEST(ArchiveRoutes, CompareTwoSessionsAndSummarizeOne) {
  write("first", 3, 0);
  write("second", 3, 3600);
  const ordered_json series = json("/sessions/first/series");
  LONGS_EQUAL(3, series["summary"]["counted"].get<int>());
  CHECK_TRUE(series["summary"]["quantities"]["e"]["total_sd"].is_number());
  LONGS_EQUAL(3, series["points"].size());
  LONGS_EQUAL(0, json("/sessions/first/series", {{"spin", "top"}})["points"].size());
  const ordered_json both = json("/compare", {{"first", "first"}, {"second", "second"}});
  CHECK_EQUAL("[3,3]", both["n"].dump());
  DOUBLES_EQUAL(0.0, both["quantities"]["e"]["difference"].get<double>(), 1e-12);  // the same shots
  json("/compare", {{"first", "first"}, {"second", "../first"}}, 404);
  json("/compare", {}, 404);
}

TEST(ArchiveRoutes, MakeNoMeanOverSurfacesUnlessAsked) {
  write("first", 3, 0);
  write_on_two_surfaces("mixed");
  const ordered_json mixed = json("/sessions/mixed/series");
  CHECK(mixed["summary"].is_null() && mixed["limits"].is_null() && mixed["points"].empty());
  CHECK_EQUAL(R"(["surface_name","ball_name"])", mixed["differ"].dump());
  CHECK_EQUAL(R"([{"name":"acrylic, no ball","counted":3,"like":"1"},{"name":"cushion, ITF type 2","counted":3,"like":"4"}])",
              mixed["conditions"].dump());
  const ordered_json one = json("/sessions/mixed/series", {{"like", "5"}});
  LONGS_EQUAL(3, one["summary"]["counted"].get<int>());
  LONGS_EQUAL(3, one["points"].size());
  CHECK_EQUAL("4", one["points"][0]["name"].get<std::string>());
  CHECK_EQUAL("[]", one["differ"].dump());
  CHECK_EQUAL("cushion, ITF type 2", one["conditions"][0]["name"].get<std::string>());
  const ordered_json over = json("/sessions/mixed/series", {{"over", "surface_name,ball_name"}});
  LONGS_EQUAL(6, over["summary"]["counted"].get<int>());
  CHECK_EQUAL("over surface, over ball", over["conditions"][0]["name"].get<std::string>());
  json("/sessions/mixed/series", {{"like", "7"}}, 404);
}

TEST(ArchiveRoutes, CompareOneConditionOfEachSession) {
  write_on_two_surfaces("mixed");
  const ordered_json both = json("/compare", {{"first", "mixed"}, {"second", "mixed"}});
  CHECK_TRUE(both["quantities"].is_null());
  LONGS_EQUAL(2, both["conditions"][1].size());
  CHECK_TRUE(json("/compare", {{"first", "mixed"}, {"first_like", "1"}, {"second", "mixed"}})["quantities"].is_null());
  const ordered_json told = json("/compare", {{"first", "mixed"}, {"first_like", "1"}, {"second", "mixed"}, {"second_like", "4"}});
  CHECK_EQUAL("[3,3]", told["n"].dump());
  CHECK_EQUAL(R"(["surface_name","ball_name"])", told["differ"].dump());
  CHECK_EQUAL("acrylic, no ball", told["conditions"][0][0]["name"].get<std::string>());
  DOUBLES_EQUAL(0.0, told["quantities"]["e"]["difference"].get<double>(), 1e-12);  // the same flights
}

TEST(ArchiveRoutes, NameTheSurfacesAndBallsOfASession) {
  write_on_two_surfaces("mixed");
  const ordered_json session = json("/sessions")[0];
  CHECK_EQUAL(R"(["acrylic","cushion"])", session["surfaces"].dump());
  CHECK_EQUAL(R"(["ITF type 2"])", session["balls"].dump());
  const ordered_json shots = json("/sessions/mixed/shots")["shots"];
  CHECK_EQUAL("cushion", shots[0]["surface"].get<std::string>());
  CHECK_EQUAL("acrylic", shots[5]["surface"].get<std::string>());
  CHECK_TRUE(shots[5]["ball"].is_null());
}

TEST(ArchiveRoutes, WriteTheReportOfTheCommand) {
  write("today", 2);
  web::Request request{"GET", "/api/v1/sessions/today/report", {}, {}, "", ""};
  CHECK_TRUE(router.find(request).work == web::Work::lasts);
  const web::Response response = router.route(request);
  LONGS_EQUAL(200, response.status);
  STRCMP_CONTAINS("text/html", response.type.c_str());
  STRCMP_CONTAINS("default-src 'none'", response.policy.c_str());
  const auto session = host::read_session(sessions / "today", {"", key_file.string(), {}}).value();
  CHECK_TRUE(*response.body == web::session_report_html(session, "1.0"));
  CHECK_TRUE(router.route(request).body == response.body);  // it is made once
  CHECK_FALSE(fs::exists(sessions / "today" / "report.html"));
}

TEST(ArchiveRoutes, OfASessionWithoutLogsTellWhatItsTableSays) {
  write("today", 2);
  for (const auto& entry : fs::directory_iterator(sessions / "today"))
    if (entry.path().extension() == ".lcmlog") fs::remove(entry.path());
  LONGS_EQUAL(2, json("/sessions/today/shots")["shots"].size());
  STRCMP_CONTAINS("no log of a host",
                  json("/sessions/today/shots/1", {}, 409)["error"].get<std::string>().c_str());
  testing::write_text(sessions / "today" / "results.csv", "");
  LONGS_EQUAL(0, json("/sessions/today/shots")["shots"].size());
}

TEST(ArchiveRoutes, OfASessionWithoutATableTellWhatItsLogsSay) {
  write("today", 3);
  fs::remove(sessions / "today" / "results.csv");
  LONGS_EQUAL(3, json("/sessions/today/shots")["shots"].size());
  CHECK_EQUAL("2", json("/sessions/today/shots/2")["name"].get<std::string>());
  LONGS_EQUAL(1, archive->sessions.readings());
}

TEST(ArchiveRoutes, OfAFolderWithoutSessionsListNone) {
  CHECK_EQUAL("[]", json("/sessions").dump());
  fs::remove_all(sessions);
  CHECK_EQUAL("[]", json("/sessions").dump());
  json("/sessions/today/shots", {}, 404);
  LONGS_EQUAL(16, json("/quantities").size());
}
