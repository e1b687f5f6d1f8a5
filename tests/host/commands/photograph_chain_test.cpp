// strobe-sim photograph, strobe digitize and strobe reduce one after the other, against the truth; and what
// strobe digitize does with options and files.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "tests/host/commands/shipped_programs.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/pictures.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::chain;
using nlohmann::json;
using testing::parse_json_lines;
using testing::write_text;

namespace {

std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string plain_number(double value) { return fmt::format("{}", value); }

double distance(const json& image, const json& other) {
  const auto &a = image.at("centre_px"), &b = other.at("centre_px");
  return std::hypot(a[0].get<double>() - b[0].get<double>(), a[1].get<double>() - b[1].get<double>());
}

}  // namespace

TEST_GROUP(PhotographChain) {
  testing::TemporaryFolder folder;

  std::string shot(const std::string& name, int number = 1) {
    return folder / (fmt::format("{}/shot_{:04}.tif", name, number));
  }
  std::vector<std::string> digitize(const std::vector<std::string>& more) {
    return with({"digitize", "--px-per-m", plain_number(kPxPerM), "--json"}, more);
  }
};

TEST(PhotographChain, ReadsWhatTheTruthTells) {
  for (const char* scene : {"zero_23", "top_42", "back_59"}) {
    const std::string name = std::string("of_") + scene;
    const auto truths = photograph(folder, name, scene, 1);
    const Run found = run_program("strobe", digitize({shot(name), "--times", folder / (name + "/truth.jsonl"),
                                                      "--px-per-m-sd", "0.15"}));
    CHECK_TEXT(found.code == 0, found.err.c_str());
    write_text(folder / "frames.jsonl", found.out);
    const Run reduced = run_program("strobe", {"reduce", folder / "frames.jsonl", "--json"});
    CHECK_TEXT(reduced.code == 0, reduced.err.c_str());
    const json readout = parse_json_lines(reduced.out).at(0), truth = truths.at(0);
    const std::string text = readout.dump();
    // A quarter of a pixel at both ends of a leg of seven images is .24 mm in 18 ms; e is a ratio of two such
    // in 10 m/s.
    CHECK_TEXT(worst_velocity_mps(readout, truth) < 0.02, text.c_str());
    const auto e = truth.at("readout").at("e").get<double>();
    DOUBLES_EQUAL_TEXT(e, readout.at("e").get<double>(), 0.003, text.c_str());
    CHECK_TEXT(spins_are_right(readout, truth), text.c_str());
  }
}

TEST(PhotographChain, WithoutAScaleFindsItAndOfAWrongOneSaysSo) {
  photograph(folder, "a", "zero_23", 1);
  const Run found = run_program("strobe", {"digitize", shot("a"), "--json"});
  CHECK_TEXT(found.code == 0, found.err.c_str());
  const json frame = parse_json_lines(found.out).at(0);
  CHECK(frame.at("inputs").at("px_per_m").is_null());
  CHECK(!frame.contains("px_per_m"));
  // Balls of a path differ by its slant to the camera; their middle is right to a tenth of a percent.
  DOUBLES_EQUAL(kPxPerM, frame.at("scale").at("px_per_m").get<double>(), 0.005 * kPxPerM);
  const Run wrong = run_program("strobe", {"digitize", shot("a"), "--px-per-m", plain_number(0.7 * kPxPerM)});
  LONGS_EQUAL(1, wrong.code);
  STRCMP_CONTAINS("the photograph's balls are about", wrong.out.c_str());
}

TEST(PhotographChain, DrawsWhatItFoundOnThePhotograph) {
  photograph(folder, "a", "zero_34", 2);
  const Run one =
      run_program("strobe", digitize({shot("a"), "--overlay", folder / "one.png", "--effort", "fast"}));
  CHECK_TEXT(one.code == 0, one.err.c_str());
  const cv::Mat bare = strobe::testing::read_picture(shot("a"));
  const cv::Mat drawn = strobe::testing::read_picture(folder / "one.png");
  CHECK(bare.size() == drawn.size() && drawn.channels() == 3);
  const std::vector<std::string> two{shot("a", 1), shot("a", 2), "--effort", "fast", "--overlay"};
  CHECK_EQUAL(2, run_program("strobe", digitize(with(two, {folder / "many.png"}))).code);
  std::filesystem::create_directory(folder / "drawn");
  const Run both = run_program("strobe", digitize(with(two, {folder / "drawn"})));
  CHECK_TEXT(both.code == 0, both.err.c_str());
  CHECK(std::filesystem::exists(folder / "drawn/shot_0001_overlay.png"));
  CHECK(std::filesystem::exists(folder / "drawn/shot_0002_overlay.png"));
}

TEST(PhotographChain, TakesAPersonsCorrections) {
  photograph(folder, "a", "zero_34", 1);
  const std::vector<std::string> words{shot("a"), "--period-ms", "3", "--effort", "fast", "--explain"};
  const json before = parse_json_lines(run_program("strobe", digitize(words)).out).at(0);
  const auto& images = before.at("images");
  CHECK(images.size() >= 8);
  const json &removed = images[1], &moved = images[3];
  const double x = moved["centre_px"][0].get<double>() + 0.5, y = moved["centre_px"][1].get<double>() - 0.25;
  write_text(folder / "edit.toml",
             fmt::format("[[remove]]\nat_px = [{}, {}]\n[[move]]\nat_px = [{}, {}]\ncentre_px = [{}, {}]\n",
                         removed["centre_px"][0].get<double>() + 2.0, removed["centre_px"][1].get<double>(),
                         x, y, x, y));
  const Run edited = run_program("strobe", digitize(with(words, {"--edit", folder / "edit.toml"})));
  CHECK_TEXT(edited.code == 0, edited.err.c_str());
  const json after = parse_json_lines(edited.out).at(0);
  LONGS_EQUAL(images.size() - 1, after.at("images").size());
  int by_hand = 0;
  for (const json& image : after.at("images")) {
    CHECK(distance(image, removed) > 5.0);
    if (image.at("source") != "hand") continue;
    ++by_hand;
    DOUBLES_EQUAL(x, image["centre_px"][0].get<double>(), 0.0);
    DOUBLES_EQUAL(y, image["centre_px"][1].get<double>(), 0.0);
  }
  LONGS_EQUAL(1, by_hand);
  bool reported = false;
  for (const json& each : after.at("unmeasured")) reported = reported || each.at("reason") == "by_hand";
  CHECK(reported);

  for (const auto& [text, place] : {std::pair{"[[remove]]\nat_px = [1, 1]\n", "edit.toml:1: "},
                                    {"[[move]]\nat_pixel = [1, 1]\n", "edit.toml:2: move[1].at_pixel: unknown key"},
                                    {"[[remove]]\nat_px = [1, 1]\nwhy = 1\n", "edit.toml:3: remove[1].why"},
                                    {"[[add]]\ncentre_px = [1]\n", "edit.toml:2: add[1].centre_px"},
                                    {"[[add\n", "edit.toml:1: "}}) {
    write_text(folder / "edit.toml", text);
    const Run wrong =
        run_program("strobe", digitize({shot("a"), "--effort", "fast", "--edit", folder / "edit.toml"}));
    LONGS_EQUAL_TEXT(2, wrong.code, text);
    LONGS_EQUAL_TEXT(1, wrong.complaints(), wrong.err.c_str());
    CHECK_EQUAL("", wrong.out);
    STRCMP_CONTAINS(place, wrong.err.c_str());
  }
}

TEST(PhotographChain, TakesTheSurfaceLineFromAPerson) {
  photograph(folder, "a", "zero_34", 1);
  const std::vector<std::string> words{shot("a"), "--period-ms", "3", "--effort", "fast"};
  const json before = parse_json_lines(run_program("strobe", digitize(words)).out).at(0);
  const json line = before.at("surface_px");
  const json &left = line.front(), &right = line.back();
  write_text(
      folder / "edit.toml",
      fmt::format("[surface]\nleft_px = [{}, {}]\nright_px = [{}, {}]\nsd_px = 0.75\n", left[0].get<double>(),
                  left[1].get<double>() + 1.0, right[0].get<double>(), right[1].get<double>() + 1.0));
  const Run edited = run_program("strobe", digitize(with(words, {"--edit", folder / "edit.toml"})));
  CHECK_TEXT(edited.code == 0, edited.err.c_str());
  const json after = parse_json_lines(edited.out).at(0);
  CHECK_EQUAL("hand", after.at("surface_source").get<std::string>());
  CHECK_FALSE(before.contains("surface_source"));
  DOUBLES_EQUAL(left[1].get<double>() + 1.0, after.at("surface_px").at(0).at(1).get<double>(), 0.0);
  DOUBLES_EQUAL(0.75, after.at("surface_sd_px").get<double>(), 0.0);
  LONGS_EQUAL(before.at("images").size(), after.at("images").size());
  // A pixel is 0.67 mm at 6.7 m/s: touchdown comes a tenth of a millisecond earlier, lift-off later by as much.
  const auto dwell_ms = [&](const std::string& frame) {
    write_text(folder / "frame.jsonl", frame);
    const Run reduced =
        run_program("strobe", {"reduce", folder / "frame.jsonl", "--format", "frame", "--json"});
    CHECK_TEXT(reduced.code == 0, reduced.err.c_str());
    return parse_json_lines(reduced.out).at(0).at("dwell_time_ms").get<double>();
  };
  const double longer_ms = dwell_ms(after.dump()) - dwell_ms(before.dump());
  CHECK_TEXT(longer_ms > 0.1 && longer_ms < 0.4, fmt::format("{}", longer_ms).c_str());
}

TEST(PhotographChain, SaysWhyAPlaceIsNoBallAndHowSureOthersAre) {
  photograph(folder, "a", "photo_blobs", 1);
  const Run found = run_program("strobe", digitize({shot("a"), "--effort", "fast", "--explain"}));
  const json frame = parse_json_lines(found.out).at(0);
  CHECK(!frame.at("images").empty());
  for (const json& each : frame.at("images")) {
    const double probability = each.at("probability");
    CHECK_TRUE(probability > 0.0 && probability <= 1.0);
  }
  CHECK(!frame.at("unmeasured").empty());
  for (const json& each : frame.at("unmeasured")) {
    CHECK(!each.at("reason").get<std::string>().empty());
    CHECK_EQUAL(2, each.at("centre_px").size());
  }
  STRCMP_CONTAINS("strobe: digitize: took ", found.err.c_str());
}

TEST(PhotographChain, NamesWhatItCannotRead) {
  photograph(folder, "a", "zero_23", 1);
  write_text(folder / "text.tif", "no photograph");
  write_text(folder / "cut.tif", testing::read_text(shot("a")).substr(0, 5000));
  write_text(folder / "no_times.json", "[0, 1, 1]\n");
  struct Case {
    std::vector<std::string> words;
    const char* named;
  };
  const std::vector<Case> cases{
      {digitize({folder / "text.tif"}), "text.tif: "},
      {digitize({folder / "cut.tif"}), "cut.tif: "},
      {digitize({folder / "absent.tif"}), "absent.tif: "},
      {digitize({folder.path()}), folder.path().c_str()},
      {digitize({shot("a"), "--times", folder / "no_times.json"}), "no_times.json:1: "},
      {digitize({shot("a"), "--times", folder / "a/truth.jsonl", "--period-ms", "3"}), "exclude"},
      {digitize({shot("a"), "--edit", folder / "absent.toml"}), "absent.toml"},
      {digitize({shot("a"), "--effort", "hasty"}), "hasty"},
      {digitize({shot("a"), "--size-tolerance", "0.3"}), "for 30 % give 30"},
      {{"digitize", shot("a"), "--px-per-m-sd", "1"}, "--px-per-m"},
      {{"digitize", shot("a"), "--rig", folder / "absent.toml"}, "absent.toml"},
  };
  for (const Case& each : cases) {
    const Run refused = run_program("strobe", each.words);
    LONGS_EQUAL_TEXT(2, refused.code, each.named);
    LONGS_EQUAL_TEXT(1, refused.complaints(), refused.err.c_str());
    STRCMP_EQUAL_TEXT("", refused.out.c_str(), each.named);
    STRCMP_CONTAINS(each.named, refused.err.c_str());
  }
  // One of two: the other is measured.
  const Run one = run_program("strobe", digitize({folder / "cut.tif", shot("a"), "--effort", "fast"}));
  LONGS_EQUAL(1, one.code);
  STRCMP_CONTAINS("cut.tif: ", one.err.c_str());
  LONGS_EQUAL(2, parse_json_lines(one.out).at(0).at("shot_id").get<int>());
}
