#include <cstdlib>
#include <filesystem>
#include <string>

#include "common/data/ball_kind.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;

namespace {

const std::string kFolder = STROBE_SOURCE_DIR "/common/data/balls/";

std::string golf_with(const std::string& found, const std::string& instead) {
  std::string text = testing::read_text(kFolder + "golf.toml");
  const auto at = text.find(found);
  CHECK_TRUE_TEXT(at != std::string::npos, found.c_str());
  return text.replace(at, found.size(), instead);
}

std::string error_of(const std::string& text) {
  const auto read = balls::read_ball_kind(text, "golf.toml");
  return read ? "" : read.error().message;
}

}  // namespace

TEST_GROUP(BallKinds) {
  void setup() override { ::setenv("STROBE_SHARE", STROBE_BUILD_DIR "/share/strobe", 1); }
  void teardown() override { ::unsetenv("STROBE_SHARE"); }
};

TEST(BallKinds, EveryShippedFileIsABallAndSaysWhereItsSizeWasRead) {
  const auto names = balls::shipped_ball_kinds();
  CHECK_TRUE(names.has_value());
  CHECK_TRUE(names->size() >= 15);
  for (const std::string& name : *names) {
    const auto kind = balls::load_ball_kind(name);
    CHECK_TRUE_TEXT(kind.has_value(), kind ? "" : kind.error().message.c_str());
    STRCMP_EQUAL(name.c_str(), kind->name.c_str());
    CHECK_TRUE_TEXT(ball::check(kind->ball()).has_value(), name.c_str());
    CHECK_FALSE_TEXT(kind->diameter_m.source.empty() || kind->mass_kg.source.empty(), name.c_str());
    CHECK_FALSE_TEXT(kind->title.empty() || kind->remarks.empty(), name.c_str());
  }
}

TEST(BallKinds, ATennisBallIsWhatIsTakenWhereNoKindIsNamed) {
  const auto tennis = balls::load_ball_kind("tennis");
  CHECK_TRUE(tennis.has_value());
  CHECK_TRUE(tennis->air == flight::AirLaw{});
  CHECK_EQUAL(ball::kThesisDiameter_m, tennis->diameter_m.value);
  CHECK_EQUAL(ball::kThesisMass_kg, tennis->mass_kg.value);
  CHECK_EQUAL(ball::kMeasuredAlpha, tennis->alpha.value);
  CHECK_EQUAL(ball::kAlphaSd, tennis->alpha.sd);
}

TEST(BallKinds, AFileIsRefusedAtTheLineThatIsWrong) {
  STRCMP_CONTAINS("golf.toml:2: marking: must be one of line,", error_of(golf_with("dimples", "dimple")).c_str());
  STRCMP_CONTAINS("marking: is missing", error_of(golf_with("marking = \"dimples\"\n", "")).c_str());
  STRCMP_CONTAINS("golf.toml:5: diameter_m.value", error_of(golf_with("value = 0.0427", "value = 42.7")).c_str());
  STRCMP_CONTAINS("air.drag", error_of(golf_with("drag_coefficient =", "drag =")).c_str());
  STRCMP_CONTAINS("air.most_mps: must not be below least_mps", error_of(golf_with("most_mps = 91.0", "most_mps = 1.0")).c_str());
  STRCMP_CONTAINS("contact.source", error_of(golf_with("\nsource = \"contact", "\nsources = \"contact")).c_str());
}

TEST(BallKinds, AnUnknownNameIsToldTheKnownOnesAndAPathIsTaken) {
  const auto unknown = balls::load_ball_kind("gulf");
  CHECK_FALSE(unknown.has_value());
  STRCMP_CONTAINS("no ball \"gulf\"", unknown.error().message.c_str());
  STRCMP_CONTAINS("golf", unknown.error().message.c_str());
  const auto golf = balls::load_ball_kind(kFolder + "golf.toml");
  CHECK_TRUE(golf.has_value());
  STRCMP_EQUAL("golf", golf->name.c_str());
}

TEST(BallKinds, WhatLiesBeyondTheMeasuredRangesIsTold) {
  const auto golf = balls::load_ball_kind("golf");
  CHECK_TRUE(balls::beyond_ranges(*golf, golf->air.most_mps, golf->contact.most_normal_mps).empty());
  CHECK_TRUE(balls::beyond_ranges(*golf, std::nullopt, std::nullopt).empty());
  const auto told = balls::beyond_ranges(*golf, 2.0 * golf->air.most_mps, 2.0 * golf->contact.most_normal_mps);
  LONGS_EQUAL(2, told.size());
  STRCMP_CONTAINS("drag and lift", told[0].c_str());
  STRCMP_CONTAINS("bounce", told[1].c_str());
}
