// Whatever is asked of the sessions' paths: an answer, nothing of what lies beside the sessions, nothing written there.
#include <rapidcheck.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "common/authentication/key_file.hpp"
#include "host/web/editing.hpp"
#include "tests/host/web/painted_session.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
namespace fs = std::filesystem;

constexpr const char* kSecret = "a secret that lies beside the sessions";

rc::Gen<std::string> part_of_path() {
  return rc::gen::oneOf(
      rc::gen::element<std::string>("api", "v1", "sessions", "today", "shots", "1", "2", "1/4d", "photograph",
                                    "preview", "corrections", "undo", "unmeasured", "series", "report",
                                    "compare", "..", ".", "", "secret.txt", "outside", "link", "%2e%2e",
                                    "results.csv", "digitizations"),
      rc::gen::arbitrary<std::string>());
}

rc::Gen<std::string> value_of_query() {
  return rc::gen::oneOf(
      rc::gen::element<std::string>("today", "1", "-1", "1e400", "../secret.txt", "outside", "nan", ""),
      rc::gen::arbitrary<std::string>());
}

rc::Gen<std::string> any_body() {
  return rc::gen::oneOf(
      rc::gen::arbitrary<std::string>(),
      rc::gen::map(rc::gen::arbitrary<std::string>(),
                   [](const std::string& text) {
                     return nlohmann::json{{"corrections", text}}.dump(
                         -1, ' ', false, nlohmann::json::error_handler_t::replace);
                   }),
      rc::gen::element<std::string>("{}", "{\"corrections\":\"[[remove]]\\nat_px=[1e5,1e5]\"}",
                                    "{\"corrections\":{}}", "[[[[", "{\"corrections\":\"[surface]\"}"));
}

std::map<std::string, std::string> texts_of(const fs::path& folder) {
  std::map<std::string, std::string> texts;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    texts[entry.path().string()] = entry.is_regular_file() ? testing::read_text(entry.path()) : "";
  return texts;
}

}  // namespace

TEST_GROUP(RandomRequests) {
  testing::TemporaryFolder place;
  fs::path sessions = place / "sessions";
  web::EventHub hub;
};

TEST(RandomRequests, AreAnsweredAndLeadNowhereElse) {
  const auto key = authentication::make_key_file(place / "lab.key").value().key;
  fs::create_directories(sessions);
  fs::create_directories(place / "outside");
  testing::write_text(place / "secret.txt", kSecret);
  testing::write_text(place / "outside" / "results.csv", kSecret);
  fs::create_directory_symlink(place / "outside", sessions / "link");
  {
    host_test::WrittenRun run(sessions / "today", key, 5, 0, web_test::painted_rig());
    web_test::add_painted_shot(run, sessions / "today", 1);
  }
  web::Archive archive({sessions, "today", (place / "lab.key").string(), "1.0"});
  web::Editing editing(archive, hub, [] { return host::Author{"ann@lab", "2026-02-01T08:00:00.000Z"}; });
  web::Router router;
  add_archive_routes(router, archive);
  add_editing_routes(router, editing);
  const auto before = texts_of(place.path());
  const std::set<int> statuses{200, 400, 404, 405, 409, 422};
  CHECK_TRUE(rc::check("with any path, query and body", [&] {
    web::Request request;
    request.method = *rc::gen::element<std::string>("GET", "POST", "HEAD");
    const int known = *rc::gen::inRange(0, 3);  // most random paths are none at all
    if (known > 0) request.path = known == 1 ? "/api/v1/sessions" : "/api/v1/sessions/today/shots";
    const auto parts = *rc::gen::container<std::vector<std::string>>(part_of_path());
    for (std::size_t i = 0; i < std::min<std::size_t>(4, parts.size()); ++i) request.path += "/" + parts[i];
    for (const char* name : {"first", "second", "limit", "before", "width", "spin", "angle"})
      if (*rc::gen::arbitrary<bool>()) request.query[name] = *value_of_query();
    request.body = *any_body();
    const web::Response response = router.route(request);
    RC_ASSERT(statuses.contains(response.status));
    RC_ASSERT(response.body != nullptr);
    RC_ASSERT(response.body->find(kSecret) == std::string::npos);
  }));
  // A shot without a correction cannot be undone, and none of these bodies corrects one.
  CHECK_TRUE(before == texts_of(place.path()));
}
