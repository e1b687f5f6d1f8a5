#include <filesystem>

#include "tests/host/commands/shipped_programs.hpp"
#include "tests/support/json_lines.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::chain;

TEST_GROUP(SimPhotograph) {
  testing::TemporaryFolder folder;

  Run take(const std::string& out, std::vector<std::string> more = {}) {
    std::vector<std::string> words{"photograph", "--scene", "photo_small", "--seed",
                                   "5",          "--out",   folder / out};
    words.insert(words.end(), more.begin(), more.end());
    return run_program("strobe-sim", words);
  }
};

TEST(SimPhotograph, WritesPhotographsAndTheirTruthAndTheSameOnesAgain) {
  const Run first = take("a/b", {"--shots", "2"});
  CHECK_TEXT(first.code == 0, first.err.c_str());
  STRCMP_CONTAINS("a/b/shot_0002.tif: 720 x 460, 8 bits, ", first.out.c_str());
  const auto truths = testing::read_json_lines(folder / "a/b/truth.jsonl");
  LONGS_EQUAL(2, truths.size());
  CHECK_EQUAL("shot_0002.tif", truths[1].at("file").get<std::string>());
  LONGS_EQUAL(720, truths[1].at("width_px").get<int>());
  const Run again = take("c", {"--shots", "2", "--json"});
  CHECK_EQUAL(testing::read_text(folder / "a/b/truth.jsonl"), again.out);
  for (const char* name : {"shot_0001.tif", "shot_0002.tif"})
    CHECK_EQUAL(testing::read_text(folder / "c" / name), testing::read_text(folder / "a/b" / name));
  int files = 0;  // and nothing under a temporary name
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder / "c")) ++files;
  LONGS_EQUAL(3, files);
  take("d", {"--seed", "6"});
  CHECK(testing::read_text(folder / "c/shot_0001.tif") != testing::read_text(folder / "d/shot_0001.tif"));
}

TEST(SimPhotograph, RefusesWhatItCannotDoInOneLine) {
  testing::write_text(folder / "file", "x");
  testing::write_text(folder / "huge.toml",
                      "inherits = \"zero_23\"\n[photograph]\nwidth_px = 20000\nheight_px = 20000\n");
  struct Case {
    Run finished;
    int code;
    const char* named;
  };
  const Case cases[] = {
      {take("a", {"--shots", "0"}), 2, "--shots"},
      {take("a", {"--period-ms", "0"}), 2, "--period-ms"},
      {take("file/a"), 2, "file/a"},
      {run_program("strobe-sim", {"photograph", "--scene", "zero_99", "--out", folder / "a"}), 2, "zero_99"},
      {run_program("strobe-sim", {"photograph", "--scene", "zero_23"}), 2, "--out"},
      {run_program("strobe-sim", {"photograph", "--scene", folder / "huge.toml", "--out", folder / "a"}), 1,
       "megapixels"},
  };
  for (const Case& each : cases) {
    LONGS_EQUAL_TEXT(each.code, each.finished.code, each.named);
    LONGS_EQUAL_TEXT(1, each.finished.complaints(), each.finished.err.c_str());
    STRCMP_CONTAINS(each.named, each.finished.err.c_str());
  }
}
