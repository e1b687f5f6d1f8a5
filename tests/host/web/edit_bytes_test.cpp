// Corrections saved on the page against `strobe shot --edit` of the shipped program, byte for byte.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "common/authentication/key_file.hpp"
#include "host/web/editing.hpp"
#include "tests/host/web/painted_session.hpp"
#include "tests/support/program_run.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
namespace fs = std::filesystem;

const std::string kStrobe = std::string(STROBE_BUILD_DIR) + "/bin/strobe";

}  // namespace

TEST_GROUP(EditBytes) {
  testing::TemporaryFolder place;
  fs::path sessions = place / "sessions";
  std::string key_file = place / "lab.key";

  /// results.csv as `strobe replay --results` writes it.
  std::string table(const fs::path& session) {
    const auto run = testing::run_program({kStrobe, "replay", session, "--results", "--key-file", key_file});
    LONGS_EQUAL_TEXT(0, run.status->code, run.err.c_str());
    return testing::read_text(session / "results.csv");
  }
};

TEST(EditBytes, OfThePageAreThoseOfTheCommand) {
  const auto key = authentication::make_key_file(key_file).value().key;
  fs::create_directories(sessions);
  const fs::path page = sessions / "page", command = sessions / "command";
  {
    host_test::WrittenRun run(page, key, 5, 0, web_test::painted_rig());
    web_test::add_painted_shot(run, page, 1);
  }
  fs::copy(page, command, fs::copy_options::recursive);
  const std::string text =
      fmt::format(
          "# by hand\n[[remove]]\nat_image_px = {}\n[[move]]\nat_image_px = {}\nequator_image_deg = 20\n",
          web_test::image_place(1), web_test::image_place(3)) +
      "[surface]\nleft_image_px = [20, 459]\nright_image_px = [940, 459.5]\n";
  testing::write_text(place / "any name.toml", text);
  const auto edited = testing::jsons_of(testing::run_program(
      {kStrobe, "shot", command, "1", "--edit", place / "any name.toml", "--json", "--key-file", key_file}));
  const std::string kept = "digitizations/shot-0001-4d-1";
  const auto by_command = nlohmann::json::parse(testing::read_text(command / (kept + ".json")));

  // The same person at the same time.
  const host::Author author{by_command.at("who"), by_command.at("utc")};
  web::Archive archive({sessions, "", key_file, "1.0"});
  web::EventHub hub;
  web::Editing editing(archive, hub, [&author] { return author; });
  web::Router router;
  add_editing_routes(router, editing);
  web::Request request{"POST", "/api/v1/sessions/page/shots/1/corrections",  {},
                       {},     nlohmann::json{{"corrections", text}}.dump(), ""};
  const web::Response saved = router.route(request);
  LONGS_EQUAL_TEXT(200, saved.status, saved.body->c_str());

  for (const char* ending : {".json", ".toml"}) {
    const std::string bytes = testing::read_text(page / (kept + ending));
    CHECK_TRUE(!bytes.empty());
    CHECK_EQUAL(testing::read_text(command / (kept + ending)), bytes);
  }
  CHECK_EQUAL(table(command), table(page));
  const auto shot = nlohmann::json::parse(*saved.body).at("shot");
  CHECK_TRUE(edited.at(0).at("vx_td_mps") == shot.at("readout").at("vx_td_mps"));

  // For a person, after the change as in the readout above it: "speed touchdown  17.02 ± 0.26  m/s".
  const auto undone = testing::run_program({kStrobe, "shot", command, "1", "--undo-edit", "--key-file", key_file});
  const std::regex row("speed touchdown +([0-9.]+) ± ([0-9.]+)"), table_row("speed touchdown m/s.* ([0-9.]+) ± ([0-9.]+)");
  std::smatch readout, after;
  CHECK_TRUE_TEXT(std::regex_search(undone.out, readout, row), undone.out.c_str());
  CHECK_TRUE_TEXT(std::regex_search(undone.out, after, table_row), undone.out.c_str());
  CHECK_EQUAL(readout.str(1) + " ± " + readout.str(2), after.str(1) + " ± " + after.str(2));
}
