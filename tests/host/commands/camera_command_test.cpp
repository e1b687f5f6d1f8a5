// `strobe camera` as a person runs it.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "tests/host/commands/shipped_programs.hpp"
#include "tests/support/json_lines.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::chain;
namespace fs = std::filesystem;

TEST_GROUP(CameraCommand) {
  testing::TemporaryFolder folder;

  std::string rig(const std::string& camera) {
    std::string text = testing::read_text(STROBE_SHIPPED_RIG);
    const auto at = text.find("[camera]\n") + 9;
    text.insert(at, camera);
    const std::string scale = "\npx_per_m = 4000.0";
    text.replace(text.find(scale), scale.size(), "\npx_per_m = 1500.0");
    testing::write_text(folder / "rig.toml", text);
    return folder / "rig.toml";
  }
};

TEST(CameraCommand, AdvisesOnPhotographsThatAreThere) {
  photograph(folder, "sound", "zero_41", 1);
  photograph(folder, "bright", "photo_saturated", 1);
  const std::string sound = folder / "sound/shot_0001.tif", bright = folder / "bright/shot_0001.tif";
  const Run first = run_program("strobe", {"camera", "--advise", sound, "--overlay", folder / "found.png"});
  CHECK_TEXT(first.code == 0, (first.out + first.err).c_str());
  STRCMP_CONTAINS("light: ok", first.out.c_str());
  CHECK(fs::file_size(folder / "found.png") > 1000);
  const Run both = run_program("strobe", {"camera", "--json", "--advise", sound, bright});
  LONGS_EQUAL(1, both.code);
  const auto lines = testing::parse_json_lines(both.out);
  LONGS_EQUAL(2, lines.size());
  CHECK_EQUAL("ok", lines[0]["verdict"].get<std::string>());
  CHECK_EQUAL(bright, lines[1]["photograph"].get<std::string>());
  CHECK_EQUAL("wrong", lines[1]["verdict"].get<std::string>());
}

TEST(CameraCommand, TakesTheNextFileOfAFolderForAPicture) {
  photograph(folder, "made", "zero_41", 1);
  fs::create_directories(folder / "arrive");
  std::jthread camera([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {  // until it is looked for
      fs::copy_file(folder / "made/shot_0001.tif", folder / "arrive/.part",
                    fs::copy_options::overwrite_existing);
      fs::rename(folder / "arrive/.part", folder / "arrive/picture.tif");
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  });
  const Run taken =
      run_program("strobe", {"camera", "--rig", rig("folder = \"arrive\"\n"), "--snap", folder / "kept.tif"});
  camera.request_stop();
  CHECK_TEXT(taken.code == 0, (taken.out + taken.err).c_str());
  STRCMP_CONTAINS("light: ok", taken.out.c_str());
  CHECK_EQUAL(testing::read_text(folder / "made/shot_0001.tif"), testing::read_text(folder / "kept.tif"));
}

TEST(CameraCommand, ComplainsInOneLine) {
  struct Case {
    Run finished;
    int code;
    const char* named;
  };
  const Case cases[] = {
      {run_program("strobe", {"camera"}), 2, "--rig"},
      {run_program("strobe", {"camera", "--list", "--watch"}), 2, "exclude each other"},
      {run_program("strobe", {"camera", "--watch"}), 2, "--rig or --photographs"},
      {run_program("strobe", {"camera", "--advise", folder / "none.tif"}), 2, "none.tif"},
      {run_program("strobe", {"camera", "--rig", folder / "none.toml"}), 2, "none.toml"},
      {run_program("strobe", {"camera", "--rig", rig("kind = \"box\"\n")}), 2, "camera.kind"},
      {run_program("strobe", {"camera", "--rig", rig("")}), 1, "camera.folder"},
  };
  for (const Case& each : cases) {
    LONGS_EQUAL_TEXT(each.code, each.finished.code, each.named);
    STRCMP_CONTAINS(each.named, each.finished.err.c_str());
  }
}
