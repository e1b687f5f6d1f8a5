// Rig files, plans and notes as the host reads them; what is wrong is named by file, line and key.
#include <string>

#include "host/assembly/camera_map.hpp"
#include "host/config/notes.hpp"
#include "host/config/plan_file.hpp"
#include "host/config/rig_file.hpp"
#include "host/photographs/measure_photograph.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using host::add_note;
using host::note_problem;
using host::PlanFile;
using host::read_plan;
using host::read_rig;

namespace {

std::string plan_error(const std::string& text) {
  return testing::error_of(read_plan(text, "PLAN.toml", {}));
}

std::string rig_error(const std::string& text) { return testing::error_of(read_rig(text, "rig.toml")); }

}  // namespace

TEST_GROUP(PlanFile){};

TEST(PlanFile, WhatItLeavesOutIsTheRigFiles) {
  PlanFile rig;
  rig.even.period = milliseconds{2};
  rig.even.impact_at = milliseconds{250};
  const auto plan = read_plan("shutter_open_ms = 400\n", "PLAN.toml", rig);
  CHECK_TRUE(plan.has_value());
  CHECK_EQUAL(rig.even.period, plan->even.period);
  CHECK_EQUAL(Duration{milliseconds{400}}, plan->even.exposure);
  CHECK_EQUAL(rig.even.impact_at, plan->even.impact_at);
}

TEST(PlanFile, ReadsAGatedTrain) {
  const auto plan = read_plan("train = \"gated\"\nflash_count = 20\ngate_delay_ms = 3.5\n", "PLAN.toml", {});
  CHECK_TRUE(plan.has_value());
  CHECK_TRUE(plan->even.train == Train::gated);
  LONGS_EQUAL(20, plan->even.flash_count);
  CHECK_EQUAL(Duration{microseconds{3500}}, plan->even.gate_delay);
}

TEST(PlanFile, IsWrittenAsItIsRead) {
  PlanFile plan;
  plan.even.period = nanoseconds{2'999'500};
  plan.even.impact_at = microseconds{120'250};
  CHECK_TRUE(*read_plan(host::plan_to_toml(plan), "PLAN.toml", {}) == plan);
  plan.even.impact_at = {};
  plan.even.train = Train::gated;
  plan.even.flash_count = 7;
  plan.even.gate_delay = milliseconds{1};
  CHECK_TRUE(*read_plan(host::plan_to_toml(plan), "PLAN.toml", {}) == plan);
}

TEST(PlanFile, NamesFileLineAndKeyOfWhatIsWrong) {
  STRCMP_EQUAL("PLAN.toml:2: perid_us: unknown key; did you mean period_us?",
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
      "[ball]\ndiameter_m = 0.0660\n[analysis]\nphotograph_timeout_s = 2\nmachine_lag_sd_ms = "
      "3\nsurface_angle_deg = 1.5\n"
      "[record]\noperator = \"A. Author\"\ntemperature_c = 21.5\nframe_number = 12\n",
      "rig.toml");
  CHECK_TRUE(rig.has_value());
  STRCMP_EQUAL("bench", rig->rig.c_str());
  STRCMP_EQUAL("udpm://239.1.1.1:7000", rig->lcm_url->c_str());
  DOUBLES_EQUAL(0.066, rig->ball.diameter_m, 0);
  DOUBLES_EQUAL(2, rig->analysis.photograph_timeout_s, 0);
  DOUBLES_EQUAL(1.5, *rig->analysis.surface_angle_deg, 0);
  DOUBLES_EQUAL(3e-3, *rig->analysis.machine_lag_sd_s, 1e-18);
  CHECK_FALSE(rig->analysis.flash_time_sd_s.has_value());
  DOUBLES_EQUAL(0.31, *rig->machine_lag_s, 1e-12);
  CHECK_EQUAL(Duration{microseconds{2500}}, rig->plan.even.period);
  STRCMP_EQUAL("21.5", rig->record.at("temperature_c").c_str());
  STRCMP_EQUAL("12", rig->record.at("frame_number").c_str());
}

TEST(RigFileOfTheHost, KnowsTheBallsMassAndInertiaOnlyWhereTheFileSaysThem) {
  const auto silent = read_rig("rig = \"b\"\n[ball]\ndiameter_m = 0.0660\n", "rig.toml");
  CHECK_FALSE(silent->ball.mass_kg.has_value());
  CHECK_FALSE(silent->ball.alpha.has_value());
  const auto said =
      read_rig("rig = \"b\"\n[ball]\nmass_kg = 0.0585\nalpha = 0.6\nalpha_sd = 0.01\nfastest_spin_radps = 500\n", "rig.toml");
  DOUBLES_EQUAL(0.0585, said->ball.mass_kg.value(), 0);
  DOUBLES_EQUAL(0.6, said->ball.alpha.value(), 0);
  DOUBLES_EQUAL(0.01, said->ball.alpha_sd.value(), 0);
  DOUBLES_EQUAL(500.0, said->ball.fastest_spin_radps.value(), 0);
}

TEST(RigFileOfTheHost, NamesWhatIsWrongInItsOwnTables) {
  STRCMP_EQUAL("rig.toml:2: ball.diametr_m: unknown key; did you mean diameter_m?",
               rig_error("rig = \"b\"\nball = { diametr_m = 1 }\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: ball.diameter_m: must be at most 1",
                  rig_error("rig = \"b\"\n[ball]\ndiameter_m = 65.1\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: ball.mass_kg: must be at least 0.001",
                  rig_error("rig = \"b\"\n[ball]\nmass_kg = 0\n").c_str());
  STRCMP_CONTAINS("rig.toml:4: ball.alpha: must be at most 0.66",
                  rig_error("rig = \"b\"\n[ball]\nmass_kg = 0.058\nalpha = 0.7\n").c_str());
  STRCMP_CONTAINS("rig: is missing", rig_error("[ball]\n").c_str());
  STRCMP_CONTAINS("rig.toml:1: rig: must be 1 to 24", rig_error("rig = \"no/slash\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:2: lcm_url: \"udpm://239.1.1.1\" is no udpm://",
                  rig_error("rig = \"b\"\nlcm_url = \"udpm://239.1.1.1\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:2: lcm_url: \"\" is no udpm://",
                  rig_error("rig = \"b\"\nlcm_url = \"\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:2: lcm_url: must be", rig_error("rig = \"b\"\nlcm_url = 5\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: record.Operator: note",
                  rig_error("rig = \"b\"\n[record]\nOperator = \"x\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: record.operator: must be a number",
                  rig_error("rig = \"b\"\n[record]\noperator = true\n").c_str());
}

TEST(RigFileOfTheHost, AFileThatIsNotThereIsNamed) {
  STRCMP_CONTAINS("rig file /nowhere/rig.toml: No such file",
                  host::load_rig("/nowhere/rig.toml").error().message.c_str());
}

TEST(RigFileOfTheHost, KeysOfTheBallGoBeforeItsKindAndAKeptFileBeforeTheNamedOne) {
  testing::TemporaryFolder folder;
  const std::string golf = testing::read_text(STROBE_SOURCE_DIR "/common/data/balls/golf.toml");
  testing::write_text(folder / "own.toml", golf);
  testing::write_text(folder / "rig.toml", "rig = \"b\"\n[ball]\nkind = \"own.toml\"\nmass_kg = 0.045\n");
  const auto rig = host::load_rig((folder / "rig.toml").string());
  CHECK_TRUE_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
  CHECK_EQUAL("own", rig->ball.kind->name);
  CHECK_EQUAL(0.0427, rig->ball.diameter_m);
  CHECK_EQUAL(0.045, rig->ball.mass_kg.value());
  CHECK_EQUAL(0.4, rig->ball.alpha.value());
  CHECK_EQUAL(golf, rig->ball_text);
  CHECK_EQUAL("ball-own.toml", host::kept_ball_file(rig->ball));
  std::string kept = golf;
  kept.replace(kept.find("0.0427"), 6, "0.0431");
  testing::write_text(folder / "ball-own.toml", kept);
  CHECK_EQUAL(0.0431, host::load_rig((folder / "rig.toml").string())->ball.diameter_m);
  testing::write_text(folder / "rig.toml", "rig = \"b\"\n[ball]\nkind = \"none.toml\"\n");
  STRCMP_CONTAINS("rig.toml: ball.kind: ", host::load_rig((folder / "rig.toml").string()).error().message.c_str());
}

TEST_GROUP(CameraTable){};

namespace {

const char* const kCalibrated =
    "rig = \"b\"\n[camera]\nfolder = \"in\"\nwidth_px = 640\nheight_px = 480\npx_per_m = 1000\npx_per_m_sd = "
    "0.5\n"
    "lens_centre_px = [319.5, 239.5]\nlens_focal_px = 900\nlens_distortion = [0, 0, 0, 0]\n"
    "rectify = [2, 0, 0, 0, -2, 958, 0, 0, 1]\nviewpoint_px = [640, 480, 5000]\n"
    "surface_px = [700, 41, 100, 40]\ncalibrated = \"2026-08-23\"\n";

std::string without(std::string text, const std::string& line_start) {
  const std::size_t at = text.find("\n" + line_start);
  return text.erase(at, text.find('\n', at + 1) - at);
}

std::string camera_error(const std::string& lines) { return rig_error("rig = \"b\"\n[camera]\n" + lines); }

}  // namespace

TEST(CameraTable, TellsTheDigitizerScaleMapAndSurface) {
  const auto rig = read_rig(kCalibrated, "rig.toml");
  CHECK_TRUE_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
  const auto settings = host::digitize_settings(*rig, 640, 480);
  CHECK_TRUE(settings.has_value());
  DOUBLES_EQUAL(1000, *settings->px_per_m, 0);
  DOUBLES_EQUAL(0.5, *settings->px_per_m_sd, 0);
  DOUBLES_EQUAL(20, settings->map.to_plane({10, 30}).x, 1e-9);
  DOUBLES_EQUAL(898, settings->map.to_plane({10, 30}).y, 1e-9);
  DOUBLES_EQUAL(5000, settings->map.viewpoint()->distance_px, 0);
  DOUBLES_EQUAL(100, settings->surface->points.front().x, 0);  // left to right
  DOUBLES_EQUAL(700, settings->surface->points.back().x, 0);
}

TEST(CameraTable, TellsAFrameOfItsScaleWhereTheLensIs) {
  const auto rig = read_rig(kCalibrated, "rig.toml");
  reduction::Frame frame;
  host::set_calibration(rig->camera, frame);
  CHECK_FALSE(frame.lens.has_value());
  frame.px_per_m = 1000.0;
  host::set_calibration(rig->camera, frame);
  DOUBLES_EQUAL(5.0, frame.lens->distance_m, 1e-12);
  DOUBLES_EQUAL(640.0, frame.lens->foot_px.x, 0.0);
  DOUBLES_EQUAL(480.0, frame.lens->foot_px.y, 0.0);
  host::CameraTable far_away = rig->camera;
  far_away.viewpoint_px.reset();
  host::set_calibration(far_away, frame);
  CHECK_FALSE(frame.lens.has_value());
}

TEST(CameraTable, APhotographOfAnotherSizeIsRefused) {
  const auto settings = host::digitize_settings(*read_rig(kCalibrated, "rig.toml"), 640, 481);
  STRCMP_EQUAL("640 x 481 pixels, but the camera's calibration is for 640 x 480",
               settings.error().message.c_str());
}

TEST(CameraTable, AScaleAloneLeavesThePhotographAsItIs) {
  const auto settings = host::digitize_settings(
      *read_rig("rig = \"b\"\n[analysis]\npx_per_m = 500\n[camera]\npx_per_m = 1000\n", "rig.toml"), 64, 48);
  DOUBLES_EQUAL(1000, *settings->px_per_m, 0);
  CHECK_TRUE(settings->map.is_uncalibrated());
  DOUBLES_EQUAL(47, settings->map.to_plane({0, 0}).y, 0);
}

TEST(CameraTable, WithoutAnyScaleLeavesItToTheDigitizer) {
  const auto settings = host::digitize_settings(*read_rig("rig = \"b\"\n", "rig.toml"), 64, 48);
  CHECK_TRUE(settings.has_value());
  CHECK_FALSE(settings->px_per_m.has_value());
}

TEST(CameraTable, NamesWhatIsWrong) {
  STRCMP_EQUAL("rig.toml:3: camera.px_per_metre: unknown key", camera_error("px_per_metre = 3\n").c_str());
  STRCMP_EQUAL("rig.toml:3: camera.px_per_m_sd: needs px_per_m too",
               camera_error("px_per_m_sd = 3\n").c_str());
  STRCMP_EQUAL("rig.toml:3: camera.folder: must not be empty", camera_error("folder = \"\"\n").c_str());
  STRCMP_EQUAL("rig.toml:3: camera.surface_px: must be 4 numbers",
               camera_error("surface_px = [1]\n").c_str());
  STRCMP_CONTAINS("two points a pixel or more apart", camera_error("surface_px = [1, 2, 1, 2]\n").c_str());
  STRCMP_CONTAINS("must be a date", camera_error("calibrated = \"2026-02-30\"\n").c_str());
  STRCMP_CONTAINS("must be a date", camera_error("calibrated = \"yesterday \"\n").c_str());
  STRCMP_CONTAINS("the distance, must be at least 1 px", camera_error("viewpoint_px = [0, 0, 0]\n").c_str());
  STRCMP_CONTAINS("lens_focal_px: needs rectify too", camera_error("lens_focal_px = 900\n").c_str());
  STRCMP_CONTAINS("must not be singular", camera_error("rectify = [1, 2, 3, 2, 4, 6, 0, 0, 1]\n").c_str());
  for (const char* key : {"width_px", "px_per_m ", "lens_centre_px", "lens_distortion"}) {
    STRCMP_CONTAINS("too", rig_error(without(kCalibrated, key)).c_str());
  }
}

TEST(CameraTable, WarnsOfAnOldCalibration) {
  using std::chrono::seconds;
  const WallTime november_21{seconds{1795219200}};  // 2026-11-21 00:00 UTC
  const auto camera = read_rig(kCalibrated, "rig.toml")->camera;
  CHECK_FALSE(host::calibration_warning(camera, november_21).has_value());  // 90 days
  STRCMP_CONTAINS("2026-08-23, 91 days ago",
                  host::calibration_warning(camera, november_21 + seconds{86'400})->c_str());
  const auto undated = read_rig(without(kCalibrated, "calibrated"), "rig.toml")->camera;
  STRCMP_CONTAINS("no date", host::calibration_warning(undated, november_21)->c_str());
  CHECK_FALSE(host::calibration_warning({}, november_21).has_value());
  const auto guess = read_rig("rig = \"b\"\n[camera]\npx_per_m = 1000\n", "rig.toml")->camera;
  CHECK_FALSE(host::calibration_warning(guess, november_21).has_value());
  STRCMP_EQUAL("2026-11-21", host::date_of(november_21 + seconds{86'399}).c_str());
  LONGS_EQUAL(-1, *host::days_since("2026-11-22", november_21));
}

TEST(CameraTable, NamesACameraAndItsSettingsInItsOwnWords) {
  const auto rig = read_rig(
      "rig = \"b\"\n[camera]\nkind = \"genicam\"\nserial = \"S7\"\naddress = \"10.0.0.9\"\nexposure = \"timed\"\n"
      "[camera.set]\nGain = 1.5\nWidth = 640\nReverseX = true\nPixelFormat = \"Mono12\"\n",
      "rig.toml");
  CHECK_TRUE(rig.has_value());
  const host::CameraConnection& camera = rig->camera.connection;
  CHECK_TRUE(camera.kind == host::CameraKind::genicam);
  STRCMP_EQUAL("S7", camera.serial.c_str());
  STRCMP_EQUAL("10.0.0.9", camera.address.c_str());
  CHECK_FALSE(camera.exposure_by_line);
  CHECK(camera.set == (std::map<std::string, std::string>{
                          {"Gain", "1.5"}, {"Width", "640"}, {"ReverseX", "true"}, {"PixelFormat", "Mono12"}}));
}

TEST(CameraTable, OfACameraThatIsNotSpokenToTakesNoSettings) {
  STRCMP_EQUAL("rig.toml:3: camera.serial: needs kind = \"genicam\" or \"gphoto2\"",
               camera_error("serial = \"S7\"\n").c_str());
  STRCMP_CONTAINS("camera.kind: must be", camera_error("kind = \"webcam\"\n").c_str());
  STRCMP_CONTAINS("camera.set.Gain", camera_error("kind = \"genicam\"\n[camera.set]\nGain = [1]\n").c_str());
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

TEST_GROUP(Statements){};

TEST(Statements, AreReadFromTheRigFileAndEmptyOnesStateNothing) {
  const auto rig = read_rig(
      "rig = \"b\"\n[laboratory]\nname = \"Lab & <Sons>\"\naddress = \"\"\n[report]\nreceived = "
      "\"2026-11-02\"\n",
      "rig.toml");
  CHECK_TRUE(rig.has_value());
  CHECK_TRUE(
      (rig->statements == host::Statements{{"laboratory", "Lab & <Sons>"}, {"received", "2026-11-02"}}));
}

TEST(Statements, OfInstrumentsHaveCertificatesAndDays) {
  const auto rig = read_rig(
      "rig = \"b\"\n[[report.instrument]]\nname = \"rule 17\"\ncertificate = \"K-1\"\ncalibrated = \"2026-03-02\"\n"
      "due = \"2027-03-02\"\n[[report.instrument]]\nname = \"inclinometer\"\n",
      "rig.toml");
  CHECK_TRUE(rig.has_value());
  LONGS_EQUAL(2, rig->instruments.size());
  CHECK_EQUAL("rule 17 K-1 2026-03-02 2027-03-02", rig->instruments[0].name + " " + rig->instruments[0].certificate + " " +
                                                       rig->instruments[0].calibrated + " " + rig->instruments[0].due);
  CHECK_EQUAL("", rig->instruments[1].certificate + rig->instruments[1].calibrated + rig->instruments[1].due);
  const std::string begin = "rig = \"b\"\n[[report.instrument]]\n";
  STRCMP_CONTAINS("rig.toml:2: report.instrument[1].name: must say which", rig_error(begin).c_str());
  STRCMP_CONTAINS("rig.toml:4: report.instrument[1].calibrated: must be a date",
                  rig_error(begin + "name = \"a\"\ncalibrated = \"March\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:5: report.instrument[1].due: must not be before",
                  rig_error(begin + "name = \"a\"\ncalibrated = \"2026-03-02\"\ndue = \"2026-03-01\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:4: report.instrument[1].serial", rig_error(begin + "name = \"a\"\nserial = \"1\"\n").c_str());
}

TEST(Statements, AreNamedWhereTheyAreWrong) {
  STRCMP_CONTAINS("rig.toml:3: report.customr",
                  rig_error("rig = \"b\"\n[report]\ncustomr = \"x\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: report.issued: must be a date, such as 2026-11-21",
                  rig_error("rig = \"b\"\n[report]\nissued = \"21.11.2026\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: laboratory.name: must be plain UTF-8",
                  rig_error("rig = \"b\"\n[laboratory]\nname = \"a\\nb\"\n").c_str());
  STRCMP_CONTAINS("rig.toml:3: laboratory.name", rig_error("rig = \"b\"\n[laboratory]\nname = 5\n").c_str());
}
