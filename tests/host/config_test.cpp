// Rig files, plans and notes as the host reads them; what is wrong is named by file, line and key.
#include <string>

#include "host/config/notes.hpp"
#include "host/config/rig_file.hpp"
#include "host/config/shot_plan.hpp"
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

using namespace strobe;
using host::add_note;
using host::note_problem;
using host::read_plan;
using host::read_rig;
using host::ShotPlan;
using host::Train;

namespace {

std::string plan_error(const std::string& text) {
  const auto plan = read_plan(text, "PLAN.toml", {});
  return plan ? "" : plan.error().message;
}

std::string rig_error(const std::string& text) {
  const auto rig = read_rig(text, "rig.toml");
  return rig ? "" : rig.error().message;
}

}  // namespace

TEST_GROUP(PlanFile){};

TEST(PlanFile, WhatItLeavesOutIsTheRigFiles) {
  ShotPlan rig;
  rig.period_us = 2000;
  rig.impact_at_ms = 250;
  const auto plan = read_plan("shutter_open_ms = 400\n", "PLAN.toml", rig);
  CHECK_TRUE(plan.has_value());
  DOUBLES_EQUAL(2000, plan->period_us, 0);
  DOUBLES_EQUAL(400, plan->shutter_open_ms, 0);
  DOUBLES_EQUAL(250, *plan->impact_at_ms, 0);
}

TEST(PlanFile, ReadsAGatedTrain) {
  const auto plan = read_plan("train = \"gated\"\nflash_count = 20\ngate_delay_ms = 3.5\n", "PLAN.toml", {});
  CHECK_TRUE(plan.has_value());
  CHECK_TRUE(plan->train == Train::gated);
  LONGS_EQUAL(20, plan->flash_count);
  DOUBLES_EQUAL(3.5, plan->gate_delay_ms, 0);
}

TEST(PlanFile, IsWrittenAsItIsRead) {
  ShotPlan plan;
  plan.period_us = 2999.5;
  plan.impact_at_ms = 120.25;
  CHECK_TRUE(*read_plan(host::plan_to_toml(plan), "PLAN.toml", {}) == plan);
  plan.impact_at_ms.reset();
  plan.train = Train::gated;
  plan.flash_count = 7;
  plan.gate_delay_ms = 1;
  CHECK_TRUE(*read_plan(host::plan_to_toml(plan), "PLAN.toml", {}) == plan);
}

TEST(PlanFile, NamesFileLineAndKeyOfWhatIsWrong) {
  STRCMP_EQUAL("PLAN.toml:2: perid_us: unknown key",
               plan_error("train = \"free\"\nperid_us = 3000\n").c_str());
  STRCMP_CONTAINS("PLAN.toml:1: period_us: must be at least 100", plan_error("period_us = 0\n").c_str());
  STRCMP_CONTAINS("PLAN.toml:1: train: must be one of free, gated", plan_error("train = \"fast\"\n").c_str());
  STRCMP_CONTAINS("PLAN.toml:1: shutter_open_ms: must be a number",
                  plan_error("shutter_open_ms = \"long\"\n").c_str());
  STRCMP_CONTAINS("PLAN.toml:1: ", plan_error("period_us = = 3\n").c_str());
}

TEST(PlanFile, RefusesWhatDoesNotFitTogether) {
  STRCMP_CONTAINS("flash_count: a gated train needs at least 1", plan_error("train = \"gated\"\n").c_str());
  STRCMP_CONTAINS("flash_count: only a gated train", plan_error("flash_count = 5\n").c_str());
  STRCMP_CONTAINS("impact_at_ms: the shutter is closed then",
                  plan_error("shutter_open_ms = 100\nimpact_at_ms = 100\n").c_str());
  STRCMP_CONTAINS("period_us: longer than the exposure",
                  plan_error("shutter_open_ms = 2\nperiod_us = 3000\n").c_str());
}

TEST_GROUP(RigFileOfTheHost){};

TEST(RigFileOfTheHost, TakesItsOwnTablesAndLeavesTheFirmwares) {
  const auto rig = read_rig(
      "rig = \"bench\"\nlcm_url = \"udpm://239.1.1.1:7000\"\n"
      "[lines]\nstrobe_a = { line = \"A\" }\n[lamps]\nwhatever = 3\n[machine]\nlag_ms = 310\npulse_ms = 20\n"
      "[plan]\nperiod_us = 2500\n"
      "[ball]\ndiameter_m = 0.0660\n[analysis]\nphotograph_timeout_s = 2\nsurface_angle_deg = 1.5\n"
      "[record]\noperator = \"A. Author\"\ntemperature_c = 21.5\nframe_number = 12\n",
      "rig.toml");
  CHECK_TRUE(rig.has_value());
  STRCMP_EQUAL("bench", rig->rig.c_str());
  STRCMP_EQUAL("udpm://239.1.1.1:7000", rig->lcm_url->c_str());
  DOUBLES_EQUAL(0.066, rig->ball.diameter_m, 0);
  DOUBLES_EQUAL(2, rig->analysis.photograph_timeout_s, 0);
  DOUBLES_EQUAL(1.5, *rig->analysis.surface_angle_deg, 0);
  DOUBLES_EQUAL(0.31, *rig->machine_lag_s, 1e-12);
  DOUBLES_EQUAL(2500, rig->plan.period_us, 0);
  STRCMP_EQUAL("21.5", rig->record.at("temperature_c").c_str());
  STRCMP_EQUAL("12", rig->record.at("frame_number").c_str());
}

TEST(RigFileOfTheHost, KnowsTheBallsMassAndInertiaOnlyWhereTheFileSaysThem) {
  const auto silent = read_rig("rig = \"b\"\n[ball]\ndiameter_m = 0.0660\n", "rig.toml");
  CHECK_FALSE(silent->ball.mass_kg.has_value());
  CHECK_FALSE(silent->ball.alpha.has_value());
  const auto said = read_rig("rig = \"b\"\n[ball]\nmass_kg = 0.0585\nalpha = 0.6\n", "rig.toml");
  DOUBLES_EQUAL(0.0585, said->ball.mass_kg.value(), 0);
  DOUBLES_EQUAL(0.6, said->ball.alpha.value(), 0);
}

TEST(RigFileOfTheHost, NamesWhatIsWrongInItsOwnTables) {
  STRCMP_EQUAL("rig.toml:2: ball.diametr_m: unknown key",
               rig_error("rig = \"b\"\nball = { diametr_m = 1 }\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: ball.diameter_m: must be at most 1",
                  rig_error("rig = \"b\"\n[ball]\ndiameter_m = 65.1\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: ball.mass_kg: must be at least 0.001",
                  rig_error("rig = \"b\"\n[ball]\nmass_kg = 0\n").c_str());
  STRCMP_CONTAINS("rig.toml:4: ball.alpha: must be at most 0.66",
                  rig_error("rig = \"b\"\n[ball]\nmass_kg = 0.058\nalpha = 0.7\n").c_str());
  STRCMP_CONTAINS("rig: is missing", rig_error("[ball]\n").c_str());
  STRCMP_CONTAINS("rig.toml:1: rig: must be 1 to 24", rig_error("rig = \"no/slash\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: record.Operator: note",
                  rig_error("rig = \"b\"\n[record]\nOperator = \"x\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: record.operator: must be a number",
                  rig_error("rig = \"b\"\n[record]\noperator = true\n").c_str());
}

TEST(RigFileOfTheHost, AFileThatIsNotThereIsNamed) {
  STRCMP_CONTAINS("/nowhere/rig.toml: No such file",
                  host::load_rig("/nowhere/rig.toml").error().message.c_str());
}

TEST_GROUP(Notes){};

TEST(Notes, AreKeyAndValue) {
  reduction::Record record;
  CHECK_TRUE(add_note(record, "operator = A. Author").has_value());
  CHECK_TRUE(add_note(record, "remarks=a=b, c").has_value());
  CHECK_TRUE(add_note(record, "operator=B").has_value());
  STRCMP_EQUAL("B", record.at("operator").c_str());
  STRCMP_EQUAL("a=b, c", record.at("remarks").c_str());
}

TEST(Notes, RefuseWhatWouldNotSurviveTheJourney) {
  reduction::Record record;
  CHECK_FALSE(add_note(record, "operator").has_value());
  CHECK_FALSE(add_note(record, "=x").has_value());
  CHECK_FALSE(add_note(record, "Operator=x").has_value());
  CHECK_FALSE(add_note(record, "two words=x").has_value());
  CHECK_FALSE(add_note(record, std::string(65, 'k').append("=x")).has_value());
  CHECK_TRUE(add_note(record, std::string(64, 'k').append("=x")).has_value());
  CHECK_FALSE(add_note(record, std::string("k=").append(1025, 'v')).has_value());
  CHECK_TRUE(add_note(record, std::string("k=").append(1024, 'v')).has_value());
  for (int i = 0; record.size() < 64; ++i)
    CHECK_TRUE(add_note(record, std::string("n").append(std::to_string(i)).append("=1")).has_value());
  CHECK_FALSE(add_note(record, "one_more=1").has_value());
  CHECK_TRUE(add_note(record, "k=again").has_value());
}

TEST(Notes, AreUtf8OnOneLine) {
  CHECK_FALSE(note_problem("k", "Grüße, 23 °C, 日本, 🎾").has_value());
  for (const char* bad :
       {"a\nb", "\x1b[31m", "\x80", "\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82", "\x7f"}) {
    CHECK_TRUE_TEXT(note_problem("k", bad).has_value(), bad);
  }
}

TEST(Notes, ANumberIsReadToItsEndOrNotAtAll) {
  const reduction::Record record{{"a", " 21.5 "}, {"b", "21.5 C"}, {"c", "nan"}, {"d", ""}, {"e", "-3"}};
  DOUBLES_EQUAL(21.5, *host::note_number(record, "a"), 0);
  CHECK_FALSE(host::note_number(record, "b").has_value());
  CHECK_FALSE(host::note_number(record, "c").has_value());
  CHECK_FALSE(host::note_number(record, "d").has_value());
  DOUBLES_EQUAL(-3, *host::note_number(record, "e"), 0);
  CHECK_FALSE(host::note_number(record, "f").has_value());
}
