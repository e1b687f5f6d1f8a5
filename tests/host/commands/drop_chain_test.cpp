// A ball dropped straight down, rendered, digitized and reduced by the shipped programs: right or not at all.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/host/commands/shipped_programs.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::chain;
using nlohmann::json;
using testing::parse_json_lines;
using testing::write_text;

namespace {

/// As high as a ball rises that leaves with that speed: drag k = density·C_D·A/(2m) of the scene's ball and air.
double risen_m(double speed_mps) {
  const double k = 1.204 * 0.55 * 3.14159265 * 0.0335 * 0.0335 / (2.0 * 0.0577), g = 9.80665;
  return std::log1p(k * speed_mps * speed_mps / g) / (2.0 * k);
}

struct Case {
  json readout, truth;
  std::string remarks;
};

Case dropped(const testing::TemporaryFolder& folder, int period_ms) {
  const std::string name = fmt::format("drop_{}", period_ms), scene = folder / (name + ".toml");
  write_text(
      scene,
      "inherits = \"drop_100in\"\n[camera]\nheight_m = 0.6\n");
  const Run made = run_program("strobe-sim", {"photograph", "--scene", scene, "--seed", "3", "--period-ms",
                                              std::to_string(period_ms), "--out", folder / name, "--json"});
  CHECK_TEXT(made.code == 0, made.err.c_str());
  const Run found = run_program(
      "strobe", {"digitize", folder / (name + "/shot_0001.tif"), "--px-per-m", "1500", "--ball-diameter-m",
                 "0.067", "--times", folder / (name + "/truth.jsonl"), "--json"});
  CHECK_TEXT(found.code == 0, found.err.c_str());
  write_text(folder / "frame.jsonl", found.out);
  const Run reduced = run_program("strobe", {"reduce", folder / "frame.jsonl", "--json"});
  CHECK_TEXT(reduced.code <= 1, reduced.err.c_str());  // 1: no number
  const json frame = parse_json_lines(found.out).at(0);
  return {parse_json_lines(reduced.out).at(0), parse_json_lines(made.out).at(0).at("readout"),
          frame.value("remarks", json::array()).dump()};
}

/// Whether the number is there; if it is, it is right: within 5 sd, and a millimetre a second for the flight's model.
bool is_read(const Case& c, const char* name) {
  const json& value = c.readout.at(name);
  if (value.is_null()) return false;
  const double sd =
      std::hypot(c.readout.at("sd").at(name).get<double>(), c.readout.at("sd_systematic").value(name, 0.0));
  DOUBLES_EQUAL_TEXT(c.truth.at(name).get<double>(), value.get<double>(), 5.0 * sd + 0.001,
                     c.readout.dump().c_str());
  return true;
}

}  // namespace

TEST_GROUP(DropChain) { testing::TemporaryFolder folder; };

TEST(DropChain, ReadsADropRightOrNotAtAll) {
  int read = 0;
  for (const int period_ms : {6, 10, 14, 30, 50}) {
    const Case c = dropped(folder, period_ms);
    const bool down = is_read(c, "vy_td_mps"), up = is_read(c, "vy_lo_mps");
    if (down && up) {
      ++read;
      // Five of its sds, as the speed that it follows from.
      const auto& drop = c.readout.at("drop");
      const double sd_m = std::hypot(drop.at("sd").at("rebound_height_m").get<double>(),
                                     drop.at("sd_systematic").at("rebound_height_m").get<double>());
      DOUBLES_EQUAL_TEXT(risen_m(c.truth.at("vy_lo_mps").get<double>()), drop.at("rebound_height_m").get<double>(),
                         5.0 * sd_m + 0.001, c.readout.dump().c_str());
      CHECK(sd_m > 0.0 && sd_m < 0.03);
    }
    if (!down && !up) STRCMP_CONTAINS("flies along one line", c.remarks.c_str());
  }
  CHECK_TRUE(read >= 2);
}

TEST(DropChain, ReadsTheFirstOfThreeBouncesOnOnePhotograph) {
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
