// The reader of truth.json: what it takes, and what it says of everything else.
#include "tests/real/collection.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe::real;

namespace {

const std::string kWhole = R"([{"file": "a.png", "ball_diameter_m": 0.04267, "px_per_m": 1743.6,
  "camera": "c", "light": "l", "ball": "b", "licence": "CC0-1.0", "source": "s", "annotator": "A", "why": "w",
  "curved": true, "bounces": true, "ghost_path": [[1, 2], [30, 40.5], [60, 80]],
  "balls": [{"x": 555.1, "y": 588.4, "d": 81, "kind": "ball", "seen": 0.99},
            {"x": 1231, "y": 364, "d": 58.9, "kind": "optional", "why": "hidden"},
            {"x": -3, "y": 10, "d": 50, "kind": "ghost"}],
  "second": {"annotator": "B", "balls": [{"x": 555.6, "y": 588, "d": 80, "kind": "ball"}]}}])";

std::string complaint(const std::string& text) {
  const auto read = parse_collection(text, "t");
  return read ? "" : read.error().message;
}

/// The whole text with one value replaced.
std::string with(const std::string& pointer, const std::string& value) {
  auto json = nlohmann::json::parse(kWhole);
  json[nlohmann::json::json_pointer(pointer)] = nlohmann::json::parse(value);
  return json.dump();
}

std::string without(const std::string& parent, const std::string& key) {
  auto json = nlohmann::json::parse(kWhole);
  json[nlohmann::json::json_pointer(parent)].erase(key);
  return json.dump();
}

}  // namespace

TEST_GROUP(RealCollection){};

TEST(RealCollection, ReadsAllFields) {
  const auto read = parse_collection(kWhole, "t");
  CHECK(read.has_value());
  const Photograph& photograph = read->at(0);
  CHECK_EQUAL("a.png", photograph.file);
  DOUBLES_EQUAL(0.04267, photograph.ball_diameter_m, 0.0);
  DOUBLES_EQUAL(1743.6, photograph.px_per_m, 0.0);
  LONGS_EQUAL(3, photograph.balls.size());
  DOUBLES_EQUAL(588.4, photograph.balls[0].y, 0.0);
  CHECK(photograph.balls[0].kind == Kind::ball);
  CHECK(photograph.balls[1].kind == Kind::optional);
  CHECK(photograph.balls[2].kind == Kind::ghost);
  LONGS_EQUAL(3, photograph.ghost_path.size());
  DOUBLES_EQUAL(40.5, photograph.ghost_path[1].y, 0.0);
  CHECK(photograph.curved);
  CHECK(photograph.bounces);
  LONGS_EQUAL(1, photograph.second->size());
}

TEST(RealCollection, NeedsNoMoreThanNameScaleAndBalls) {
  const auto read =
      parse_collection(R"([{"file": "a.png", "ball_diameter_m": 1, "px_per_m": 2, "balls": []}])", "t");
  CHECK(read.has_value());
  CHECK(read->at(0).ghost_path.empty());
  CHECK_FALSE(read->at(0).second.has_value());
}

TEST(RealCollection, NamesPhotographAndFieldOfWhatIsWrong) {
  CHECK_EQUAL("t: is not JSON", complaint("[{"));
  CHECK_EQUAL("t: must be a list of photographs", complaint("{}"));
  CHECK_EQUAL("t: photograph 1: must be an object", complaint("[3]"));
  CHECK_EQUAL("t: photograph 1: lacks \"file\"", complaint("[{}]"));
  CHECK_EQUAL("t: photograph 1 (a.png): lacks \"px_per_m\"", complaint(without("/0", "px_per_m")));
  CHECK_EQUAL("t: photograph 1 (a.png): has no field \"ghost_pth\"", complaint(with("/0/ghost_pth", "[]")));
  CHECK_EQUAL("t: photograph 1 (a.png): balls[1]: has no field \"r\"", complaint(with("/0/balls/1/r", "3")));
  CHECK_EQUAL("t: photograph 1 (a.png): balls[0]: lacks \"kind\"", complaint(without("/0/balls/0", "kind")));
  CHECK_EQUAL("t: photograph 1 (a.png): balls[2]: kind: must be \"ball\", \"optional\" or \"ghost\"",
              complaint(with("/0/balls/2/kind", "\"gost\"")));
  CHECK_EQUAL("t: photograph 1 (a.png): balls[0]: d: must be a number above 0 and at most 1000000",
              complaint(with("/0/balls/0/d", "0")));
  CHECK_EQUAL("t: photograph 1 (a.png): balls[0]: seen: must be a number from 0 and at most 1",
              complaint(with("/0/balls/0/seen", "1.1")));
  CHECK_EQUAL("t: photograph 1 (a.png): ghost_path: must have two corners or more",
              complaint(with("/0/ghost_path", "[[1, 2]]")));
  CHECK_EQUAL("t: photograph 1 (a.png): ghost_path[1]: must be [x, y]",
              complaint(with("/0/ghost_path/1", "[1]")));
  CHECK_EQUAL("t: photograph 1 (a.png): ghost_path[1]: is the corner before it once more",
              complaint(with("/0/ghost_path/1", "[1, 2]")));
  CHECK_EQUAL("t: photograph 1 (a.png): second: balls: must be a list",
              complaint(with("/0/second/balls", "7")));
  CHECK_EQUAL("t: photograph 1 (a.png): curved: must be true or false", complaint(with("/0/curved", "1")));
  CHECK_EQUAL("t: photograph 1 (a.png): licence: must be a text", complaint(with("/0/licence", "\"\"")));
  CHECK_EQUAL("t: photograph 2 (a.png): stands there twice",
              complaint("[" + kWhole.substr(1, kWhole.size() - 2) + "," + kWhole.substr(1)));
}

TEST(RealCollection, AFilesNameMayBeLong) {
  CHECK_EQUAL("", complaint(with("/0/file", '"' + std::string(200, 'n') + ".png\"")));
}

TEST(RealCollection, OpensNoFileOutsideItsFolder) {
  for (const char* name :
       {"\"/etc/passwd\"", "\"../a.png\"", "\"b/../../a.png\"", "\"a\\u0000.png\"", "\"a\\n.png\""})
    STRCMP_CONTAINS("file: must be the name of a file in this folder",
                    complaint(with("/0/file", name)).c_str());
}

TEST(RealCollection, NoTextMakesItThrow) {
  for (std::size_t length = 0; length < kWhole.size(); ++length)
    CHECK(!complaint(kWhole.substr(0, length)).empty());
  const std::vector<std::string> values{"null", "true", "-1", "1e999",  "1e308",        "\"\"",       "\"x\"",
                                        "[]",   "[[]]", "{}", "[null]", "[{\"x\": 1}]", "\"\\ud800\""};
  const auto flat = nlohmann::json::parse(kWhole).flatten();
  for (const auto& [pointer, old] : flat.items())
    for (const std::string& value : values) {
      auto json = nlohmann::json::parse(kWhole);
      json[nlohmann::json::json_pointer(pointer)] = nlohmann::json::parse(value, nullptr, false);
      const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
      const std::string words = complaint(text);
      CHECK(words.find('\n') == std::string::npos);
    }
  CHECK(!complaint(std::string(100'000, '[')).empty());
}

TEST(RealCollection, SaysWhichPhotographIsNotThere) {
  const strobe::testing::TemporaryFolder folder;
  CHECK_FALSE(load_collection(folder.path()).has_value());
  strobe::testing::write_text(folder / "truth.json", kWhole);
  CHECK_EQUAL((folder / "truth.json").string() + ": a.png: no such file",
              load_collection(folder.path()).error().message);
  strobe::testing::write_text(folder / "a.png", "x");
  CHECK_EQUAL((folder / "a.png").string(), load_collection(folder.path())->at(0).path.string());
}
