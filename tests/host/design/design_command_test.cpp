// strobe design, as shipped.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/support/program_run.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;

auto design(std::vector<std::string> words) {
  words.insert(words.begin(), {STROBE_PROGRAM, "design"});
  return testing::run_program(std::move(words));
}

void refuses(const char* what, std::vector<std::string> words) {
  const auto run = design(std::move(words));
  LONGS_EQUAL(2, run.status->code);
  STRCMP_EQUAL("", run.out.c_str());
  STRCMP_CONTAINS(what, run.err.c_str());
}

const std::vector<std::string> kBall{"--speed", "17", "--angle", "23", "--e", "0.86", "--e-sd", "0.02"};

std::vector<std::string> with(std::vector<std::string> words) {
  words.insert(words.begin(), kBall.begin(), kBall.end());
  return words;
}

}  // namespace

TEST_GROUP(DesignCommand){};

TEST(DesignCommand, RefusesInOneLineThatNamesTheOption) {
  refuses("which ball? --speed and --angle", {});
  refuses("the ball's angle", {"--speed", "17", "--angle", "0.2"});
  refuses("--want e", with({"--want", "e"}));
  refuses("--plan: nowhere.toml", with({"--plan", "nowhere.toml"}));
  refuses("--scene: nowhere.toml", {"--scene", "nowhere.toml"});
  refuses("go together", with({"--focal-mm", "50"}));
  refuses("no usual lens sees", with({"--distance-m", "0.02", "--pixel-um", "4.5"}));
  refuses("nowhere: no such folder", {"--like", "nowhere"});
}

TEST(DesignCommand, TellsWhatToExpectAndWhatItTakes) {
  const auto run = design(with({"--want", "e:0.01", "--difference", "e:0.01", "--power", "0.9", "--json"}));
  LONGS_EQUAL(0, run.status->code);
  const auto json = nlohmann::json::parse(run.out);
  DOUBLES_EQUAL(0.86, json["quantities"]["e"]["expected"].get<double>(), 0.01);
  // The machine's own spread decides: 0.02 t(n - 1)/sqrt(n) is 0.01 at 18 balls; a difference takes 2 (1.96 + 1.28)²
  // sd² over its square: some 85 of each.
  const int shots = json["needs"][0]["shots"].get<int>();
  const int of_each = json["needs"][1]["shots"].get<int>();
  CHECK(shots >= 16 && shots <= 21);
  CHECK(of_each >= 80 && of_each <= 92);
}

TEST(DesignCommand, WritesAPlanAndDrawings) {
  const testing::TemporaryFolder folder;
  const std::string plan = (folder.path() / "plan.toml").string(), figures = (folder.path() / "figures").string();
  const auto run = design(with({"--by", "hand", "--write-plan", plan, "--figures", figures}));
  LONGS_EQUAL(0, run.status->code);
  STRCMP_CONTAINS("times as certain", run.out.c_str());
  const auto again = design(with({"--by", "hand", "--plan", plan, "--json"}));
  LONGS_EQUAL(0, again.status->code);
  for (const char* file : {"images.svg", "images.csv", "uncertainty.svg", "uncertainty.csv"})
    CHECK_TRUE(std::filesystem::exists(std::filesystem::path(figures) / file));
}

TEST(DesignCommand, SaysThatABallIsTooSmallToBeRead) {
  const auto run = design(with({"--px-per-m", "500"}));
  LONGS_EQUAL(1, run.status->code);
  STRCMP_CONTAINS("not known for balls of 33 px", run.out.c_str());
}
