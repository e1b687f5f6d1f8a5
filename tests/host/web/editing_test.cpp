// Corrections over HTTP: what they would do, saved and taken back, against `strobe shot --edit`'s own way.
#include "host/web/editing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/authentication/key_file.hpp"
#include "host/archive/read_session.hpp"
#include "host/archive/redigitize.hpp"
#include "host/archive/shot_outcome.hpp"
#include "tests/host/web/painted_session.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using nlohmann::ordered_json;
namespace fs = std::filesystem;
using host_test::WrittenRun;

const host::Author kAuthor{"ann@lab", "2026-02-01T08:00:00.000Z"};

std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files[entry.path().lexically_relative(folder).string()] = testing::read_text(entry.path());
  return files;
}

}  // namespace

TEST_GROUP(EditingRoutes) {
  testing::TemporaryFolder place;
  fs::path sessions = place / "sessions";
  fs::path today = sessions / "today";
  fs::path key_file = place / "lab.key";
  authentication::Key key = authentication::make_key_file(key_file).value().key;
  std::unique_ptr<web::Archive> archive;
  web::EventHub hub;
  std::unique_ptr<web::Editing> editing;
  web::Router router;

  void setup() override {
    fs::create_directories(sessions);
    {
      WrittenRun run(today, key, 5, 0, web_test::painted_rig());
      web_test::add_painted_shot(run, today, 1);
    }
    open();
  }
  void open() {
    archive =
        std::make_unique<web::Archive>(web::SessionStoreSettings{sessions, "", key_file.string(), "1.0"});
    editing = std::make_unique<web::Editing>(*archive, hub, [] { return kAuthor; });
    router = {};
    add_archive_routes(router, *archive);
    add_editing_routes(router, *editing);
  }
  web::Response ask(const std::string& method, const std::string& path, const std::string& body = "") {
    web::Request request{method, "/api/v1/sessions/today/shots/" + path, {}, {}, body, ""};
    return router.route(request);
  }
  ordered_json json_of(const web::Response& response, int status = 200) {
    LONGS_EQUAL_TEXT(status, response.status, response.body->c_str());
    return ordered_json::parse(*response.body);
  }
  static std::string body_of(const std::string& corrections) {
    return ordered_json{{"corrections", corrections}}.dump();
  }
  static std::string corrections() {
    return fmt::format(
               "[[remove]]\nat_image_px = {}\n[[move]]\nat_image_px = {}\nequator_image_deg = 20\n",  //
               web_test::image_place(1), web_test::image_place(3)) +
           "[surface]\nleft_image_px = [20, 459]\nright_image_px = [940, 459.5]\nsd_px = 0.4\n";
  }
};

TEST(EditingRoutes, APreviewSaysWhatSavingWouldGiveAndWritesNothing) {
  const auto before = files_of(today);
  const ordered_json seen = json_of(ask("POST", "1/preview", body_of(corrections())));
  CHECK_TRUE_TEXT(seen["problem"].is_null(), seen["problem"].dump().c_str());
  CHECK_TRUE(before == files_of(today));
  CHECK_TRUE(seen["surface_by_hand"].get<bool>());
  const ordered_json saved = json_of(ask("POST", "1/corrections", body_of(corrections())));
  CHECK_TRUE(saved["changed"].get<bool>());
  const ordered_json& shot = saved["shot"];
  CHECK_EQUAL(seen["after"].dump(), shot["values"].dump());
  CHECK_EQUAL(seen["images"].dump(), shot["images"].dump());
  CHECK_EQUAL(seen["surface_px"].dump(), shot["surface_px"].dump());
  CHECK_EQUAL("corrected", shot["digitization"].get<std::string>());
  CHECK_TRUE(shot["surface_by_hand"].get<bool>());
  CHECK_TRUE(seen["before"].dump() != seen["after"].dump());
  STRCMP_CONTAINS("removed by shot-0001-4d-1.toml:1", shot["unmeasured"].dump().c_str());
  STRCMP_CONTAINS("event: edited\ndata: {\"session\":\"today\",\"shot\":\"1\"}",
                  hub.take_after(0, 10000).text.c_str());
}

/// Where it is no flight passes, so that times are left open.
TEST(EditingRoutes, AnImageThatNoFlashCanHaveMadeIsMeasuredAllTheSame) {
  const std::string added = "[[add]]\ncentre_image_px = [480, 60]\ndiameter_image_px = 64\n";
  const ordered_json seen = json_of(ask("POST", "1/preview", body_of(added)));
  CHECK_TRUE(seen["after"].is_object());
  const ordered_json saved = json_of(ask("POST", "1/corrections", body_of(added)));
  CHECK_EQUAL(seen["images"].dump(), saved["shot"]["images"].dump());
  const auto& images = saved["shot"]["images"];
  CHECK_TRUE(std::ranges::any_of(images, [](const ordered_json& image) {
    return image["source"] == "hand" && !image["used"].get<bool>() && image["why_not"].is_string();
  }));
  const auto session = host::read_session(today, {"", key_file.string(), {}}).value();
  CHECK_TRUE(session.remarks.empty() || session.remarks[0].find("digitizations") == std::string::npos);
  LONGS_EQUAL(images.size(), session.shots[0].digitizations.back().frame.images.size());
}

TEST(EditingRoutes, WhatWasSavedIsTakenBackAsItCame) {
  const ordered_json first = json_of(ask("GET", "1"));
  CHECK_EQUAL("auto", first["digitization"].get<std::string>());
  json_of(ask("POST", "1/corrections", body_of(corrections())));
  CHECK_FALSE(json_of(ask("POST", "1/corrections", body_of(corrections())))["changed"].get<bool>());
  const ordered_json undone = json_of(ask("POST", "1/undo", "{}"));
  CHECK_EQUAL(first.dump(), undone["shot"].dump());
  CHECK_TRUE(fs::exists(today / "digitizations" / "shot-0001-4d-1.json.undone"));
  STRCMP_CONTAINS("no correction to be taken back", json_of(ask("POST", "1/undo", "{}"), 422).dump().c_str());
  const int readings = archive->sessions.readings();
  LONGS_EQUAL(1, readings);  // a change needs no second reading
  open();
  CHECK_EQUAL(first.dump(), json_of(ask("GET", "1")).dump());  // nor does it differ from one
}

TEST(EditingRoutes, CorrectionsThatCannotBeReadAreToldAndChangeNothing) {
  const auto before = files_of(today);
  for (const auto& [text, words] :
       {std::pair{"", "no [[add]]"},
        std::pair{"[[add]]\ncentre_px = [1]\n", "corrections.toml:2: add[1].centre_px"},
        std::pair{"[[remove]]\nat_image_px = [5, 5]\n", "corrections.toml:1: no image within"}}) {
    const ordered_json seen = json_of(ask("POST", "1/preview", body_of(text)));
    STRCMP_CONTAINS(words, seen["problem"].get<std::string>().c_str());
    CHECK_TRUE(seen["after"].is_null());
    STRCMP_CONTAINS(
        words, json_of(ask("POST", "1/corrections", body_of(text)), 422)["error"].get<std::string>().c_str());
  }
  for (const char* body : {"", "[]", "{", "{\"corrections\":3}", "null"}) {
    json_of(ask("POST", "1/preview", body), 400);
    json_of(ask("POST", "1/corrections", body), 400);
  }
  json_of(ask("POST", "2/corrections", body_of(corrections())), 404);
  json_of(ask("POST", "../1/corrections", body_of(corrections())), 404);
  CHECK_TRUE(before == files_of(today));
}

/// 240 kB, of which the parser would make as many tables within each other.
TEST(EditingRoutes, WhatNoParserCanTakeIsRefusedAndTheHostGoesOn) {
  std::string keys;
  for (int i = 0; i < 120'000; ++i) keys += "a.";
  for (const char* path : {"1/preview", "1/corrections"}) {
    const ordered_json refused = json_of(ask("POST", path, body_of(keys + "a = 1\n")), 400);
    CHECK_EQUAL("corrections.toml:1: a key of more than 16 parts", refused["error"].get<std::string>());
    json_of(ask("POST", path, std::string(240'000, '[')), 400);
    json_of(
        ask("POST", path,
            "{\"corrections\":\"\",\"more\":" + std::string(120'000, '[') + std::string(120'000, ']') + "}"),
        400);
  }
  CHECK_TRUE(json_of(ask("POST", "1/preview", body_of(corrections())))["after"].is_object());
}

TEST(EditingRoutes, AKeptDigitizationThatNestsTooDeepIsLeftOut) {
  json_of(ask("POST", "1/corrections", body_of(corrections())));
  const fs::path kept = today / "digitizations" / "shot-0001-4d-1.json";
  std::string text = testing::read_text(kept);
  text.insert(text.rfind('}'), ",\"unmeasured\":" + std::string(200'000, '[') + std::string(200'000, ']'));
  testing::write_text(kept, text);
  open();
  const ordered_json shot = json_of(ask("GET", "1"));
  CHECK_EQUAL("auto", shot["digitization"].get<std::string>());
}

TEST(EditingRoutes, NothingIsWrittenWhereALinkLeads) {
  const fs::path outside = place / "outside";
  fs::create_directories(outside);
  fs::create_directory_symlink(outside, today / "digitizations");
  json_of(ask("POST", "1/corrections", body_of(corrections())), 409);
  CHECK_TRUE(fs::is_empty(outside));
}

TEST(EditingRoutes, AnEditorBeginsWithWhatWasFoundAndWhatCounts) {
  const ordered_json found = json_of(ask("GET", "1/corrections"));
  CHECK_TRUE(found["corrections"].empty());
  CHECK_TRUE(found["found"]["images"].size() > 8);
  json_of(ask("POST", "1/corrections", body_of(corrections())));
  const ordered_json again = json_of(ask("GET", "1/corrections"));
  CHECK_EQUAL(found["found"].dump(), again["found"].dump());
  LONGS_EQUAL(3, again["corrections"].size());
  CHECK_EQUAL("surface", again["corrections"][2]["kind"].get<std::string>());
  CHECK_TRUE(json_of(ask("GET", "1/unmeasured"))["unmeasured"].is_array());
}

TEST(EditingRoutes, ShowThePhotographAsItIsMeasured) {
  const ordered_json detail = json_of(ask("GET", "1"));
  LONGS_EQUAL(web_test::kWidth_px, detail["photograph"]["width_px"].get<int>());
  CHECK_EQUAL("/api/v1/sessions/today/shots/1/photograph", detail["photograph"]["url"].get<std::string>());
  // Measured again it lies where the frame in the log says: to a quarter of a pixel.
  const ordered_json found = json_of(ask("GET", "1/corrections"))["found"];
  LONGS_EQUAL(detail["images"].size(), found["images"].size());
  for (std::size_t i = 0; i < detail["images"].size(); ++i) {
    if (detail["images"][i]["leg"] == "contact") continue;
    for (const int axis : {0, 1})
      DOUBLES_EQUAL(detail["images"][i]["centre_px"][axis].get<double>(),
                    found["images"][i]["centre_px"][axis].get<double>(), 0.25);
  }
}
