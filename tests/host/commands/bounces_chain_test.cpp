// A ball that bounces three times on one photograph: the first bounce is read, by the shipped programs.
#include <algorithm>

#include "tests/host/commands/shipped_programs.hpp"
#include "tests/support/json_lines.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::chain;
using nlohmann::json;
using testing::parse_json_lines;
using testing::write_text;

TEST_GROUP(BouncesChain) { testing::TemporaryFolder folder; };

TEST(BouncesChain, ReadsTheFirstOfThreeBounces) {
  const std::string scene = folder / "bounces.toml";
  write_text(
      scene,
      "inherits = \"photo_bounces\"\n[camera]\npx_per_m = 1500\norigin_x_px = 625\norigin_y_px = 75\n");
  const Run made =
      run_program("strobe-sim", {"photograph", "--scene", scene, "--period-ms", "40", "--exposure-ms", "1000",
                                 "--out", folder / "pictures", "--json"});
  CHECK_TEXT(made.code == 0, made.err.c_str());
  const json truth = parse_json_lines(made.out).at(0);
  const Run found =
      run_program("strobe", {"digitize", folder / "pictures/shot_0001.tif", "--px-per-m", "1500",
                             "--ball-diameter-m", "0.0651", "--period-ms", "40", "--json"});
  CHECK_TEXT(found.code == 0, found.err.c_str());
  const json images = parse_json_lines(found.out).at(0).at("images");
  const auto of_leg = [&](const char* leg) {
    return std::ranges::count_if(images, [&](const json& i) { return i.value("leg", "") == leg; });
  };
  // Seven flashes light the ball before the bounce, six between it and the next.
  LONGS_EQUAL(7, of_leg("incoming"));
  LONGS_EQUAL(6, of_leg("rebound"));
  write_text(folder / "frame.jsonl", found.out);
  const Run reduced = run_program("strobe", {"reduce", folder / "frame.jsonl", "--json"});
  CHECK_TEXT(reduced.code == 0, reduced.err.c_str());
  // 4 mm/s: three sds of .3, .6 that the drag's series leaves over a leg of .25 s, and 2 from where the surface is:
  // .3 px are .2 mm, by which a ball of 1.1 m/s falls so much faster.
  CHECK(worst_velocity_mps(parse_json_lines(reduced.out).at(0), truth) < 0.004);
}
