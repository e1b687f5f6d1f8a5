// Coded trains on the host: from the plan file to the command, from the photograph to the flashes that made
// it, and what such a shot tells of the bench.
#include <cmath>

#include "host/assembly/assemble.hpp"
#include "common/reduction/matching/flash_match.hpp"
#include "host/config/plan_file.hpp"
#include "host/session/shot.hpp"
#include "host/session/train_report.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/error_of.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::host_test;
using host::PlanFile;

Result<PlanFile> read(const std::string& text, const PlanFile& defaults = {}) {
  return host::read_plan(text, "PLAN.toml", defaults);
}
std::string error_of(const std::string& text) { return testing::error_of(read(text)); }

}  // namespace

TEST_GROUP(CodedPlanFile){};

TEST(CodedPlanFile, RepeatsItsIntervalsOverTheExposure) {
  const auto plan = read("intervals_us = [3000, 3000, 3500]\nshutter_open_ms = 20\n");
  const CodedTrain code = plan->shot().code;
  const int offsets_us[] = {0, 3000, 6000, 9500, 12500, 15500, 19000};
  LONGS_EQUAL(std::size(offsets_us), code.size());
  for (std::size_t i = 0; i < code.size(); ++i) {
    CHECK(code[i] == (CodedFlash{microseconds{offsets_us[i]}, Lamps::both}));
  }
}

TEST(CodedPlanFile, LeavesFlashesOutAndGivesSomeToOneLamp) {
  const auto plan =
      read("period_us = 3000\nshutter_open_ms = 20\nomit = [3]\nonly_a = [1, 5]\nonly_b = [4]\n");
  const CodedTrain code = plan->shot().code;
  LONGS_EQUAL(6, code.size());
  CHECK(code[0] == (CodedFlash{{}, Lamps::both}));
  CHECK(code[1] == (CodedFlash{milliseconds{3}, Lamps::a}));
  CHECK(code[3] == (CodedFlash{milliseconds{12}, Lamps::b}));
  CHECK(code[4] == (CodedFlash{milliseconds{15}, Lamps::a}));
}

TEST(CodedPlanFile, IsAnEvenTrainWithoutThem) {
  CHECK(read("period_us = 2000\n")->shot().code.empty());
  CHECK(read("omit = []\n")->shot().code.empty());
}

TEST(CodedPlanFile, HasPeriodOrIntervalsWhicheverItNamesItself) {
  PlanFile rig;
  rig.intervals = {microseconds{3000}, microseconds{3400}};
  rig.omit = {4};
  const auto even = read("period_us = 2000\nomit = []\n", rig);
  CHECK_FALSE(even->coded());
  CHECK(even->even.period == milliseconds{2});
  const auto same = read("shutter_open_ms = 300\n", rig);
  CHECK(same->intervals == rig.intervals && same->omit == rig.omit);
  STRCMP_EQUAL("PLAN.toml:2: intervals_us: must not be given together with period_us",
               error_of("period_us = 3000\nintervals_us = [3000]\n").c_str());
}

TEST(CodedPlanFile, IsSpacedAsItSaysAndEvenWhereItNamesAPeriodAlone) {
  using host::Spacing;
  const PlanFile rig = *read("period_us = 3000\nspacing = \"coded\"\n");
  CHECK(rig.spacing == Spacing::coded && rig.shot().code.empty());
  CHECK(*read(host::plan_to_toml(rig)) == rig);
  CHECK(read("shutter_open_ms = 300\n", rig)->spacing == Spacing::coded);
  CHECK(read("spacing = \"even\"\n", rig)->spacing == Spacing::even);
  CHECK(read("period_us = 2000\n", rig)->spacing == Spacing::even);
  CHECK(read("intervals_us = [3000, 3100]\n", rig)->spacing == Spacing::even);
  CHECK(read("omit = [3]\n", rig)->spacing == Spacing::even);
  PlanFile own;
  own.intervals = {microseconds{3000}, microseconds{3400}};
  CHECK(read("spacing = \"coded\"\n", own)->intervals.empty());
  STRCMP_CONTAINS("PLAN.toml:2: spacing: must not be given together with intervals_us, omit, only_a or only_b",
                  error_of("intervals_us = [3000, 3100]\nspacing = \"even\"\n").c_str());
  STRCMP_CONTAINS("spacing: must not be given together", error_of("omit = [2]\nspacing = \"coded\"\n").c_str());
  CHECK(read("omit = [2]\nspacing = \"even\"\n")->coded());
  STRCMP_CONTAINS("spacing: must be one of even, coded", error_of("spacing = \"odd\"\n").c_str());
}

TEST(CodedPlanFile, IsWrittenAsItIsRead) {
  PlanFile plan = *read("intervals_us = [3000, 3100.5]\nomit = [9, 3]\nonly_a = [1]\nonly_b = [2]\n");
  CHECK(plan.omit == (std::vector<int>{3, 9}));
  CHECK(*read(host::plan_to_toml(plan)) == plan);
  plan.even.train = Train::gated;
  plan.even.flash_count = 20;
  CHECK(*read(host::plan_to_toml(plan)) == plan);
}

TEST(CodedPlanFile, RefusesWhatIsNotInTheTrain) {
  STRCMP_EQUAL("PLAN.toml:2: omit: no flash 7 in a train of 7",
               error_of("shutter_open_ms = 20\nomit = [7]\n").c_str());
  STRCMP_CONTAINS("only_b: flash 2 is named in another list as well",
                  error_of("omit = [2]\nonly_b = [2]\n").c_str());
  STRCMP_CONTAINS("omit: names a flash twice", error_of("omit = [2, 2]\n").c_str());
  STRCMP_CONTAINS("only_a: flashes have whole numbers", error_of("only_a = [2.5]\n").c_str());
  STRCMP_CONTAINS("omit: must be at least 0", error_of("omit = [-1]\n").c_str());
  STRCMP_CONTAINS("intervals_us: must be at least 100", error_of("intervals_us = [3000, 0]\n").c_str());
  STRCMP_CONTAINS("omit: leaves no flash", error_of("shutter_open_ms = 5\nomit = [0, 1]\n").c_str());
  STRCMP_CONTAINS("a coded train has at most 1024 flashes",
                  error_of("period_us = 100\nshutter_open_ms = 500\nomit = [1]\n").c_str());
}

TEST(CodedPlanFile, GoesWithTheShot) {
  const ShotPlan plan =
      read("intervals_us = [3000, 3400]\nshutter_open_ms = 15\nonly_a = [2]\ngate_delay_ms = 2\n")->shot();
  LONGS_EQUAL(5, plan.code.size());
  LONGS_EQUAL(0, plan.flash_count);
  CHECK(plan.period == milliseconds{3} && plan.exposure == milliseconds{15});
  CHECK(plan.gate_delay == Duration{});  // a free train has no gate
  CHECK(plan.code[2] == (CodedFlash{microseconds{6400}, Lamps::a}));
  CHECK(plan.code[3].lamps == Lamps::both);
  const ShotPlan gated =
      read("train = \"gated\"\nflash_count = 9\nomit = [4, 5]\ngate_delay_ms = 2\n")->shot();
  LONGS_EQUAL(7, gated.code.size());
  LONGS_EQUAL(7, gated.flash_count);
  CHECK(gated.gate_delay == milliseconds{2});
}

TEST_GROUP(CodedPhotograph) {
  host::AssemblySettings settings;

  host::AssembledShot assembled(const SyntheticShot& made) {
    return host::assemble(made.shot, made.frame, settings);
  }
  static std::vector<int> flashes_of(const host::AssembledShot& shot) {
    std::vector<int> flashes;
    for (const auto& image : shot.frame.images) flashes.push_back(image.flash_index.value_or(-1));
    return flashes;
  }
};

TEST(CodedPhotograph, OfAnEvenTrainLeavesOpenWhichFlashesMadeIt) {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    Scenario even;
    even.seed = seed;
    const auto shot = assembled(make_shot(even));
    // Of 166 flashes a dozen show the ball: some 150 places are alike.
    CHECK(shot.flashes->misassignment_probability > 0.9);
    CHECK_FALSE(shot.flashes->coded || shot.flags.has(reduction::Flag::flash_index_ambiguous));
    CHECK_FALSE(shot.flags.has(reduction::Flag::flash_match_ambiguous));  // its numbers do not depend on it
  }
}

TEST(CodedPhotograph, OfACodedTrainTellsItsFlashes) {
  // Twelve intervals, none of whose runs of eight comes twice: 3 ms or a tenth more.
  const std::vector<double> code{3.0e-3, 3.0e-3, 3.3e-3, 3.0e-3, 3.6e-3, 3.3e-3, 3.0e-3, 3.9e-3,
                                 3.3e-3, 3.6e-3, 3.0e-3, 4.2e-3, 3.6e-3, 3.9e-3, 3.3e-3, 4.2e-3};
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    Scenario coded;
    coded.seed = seed;
    coded.intervals_s = code;
    coded.flash_count = 16;  // each place of the code once
    coded.touchdown_s = 0.0275 + 0.0003 * seed;
    const SyntheticShot made = make_shot(coded);
    const auto shot = assembled(made);
    CHECK(flashes_of(shot) == made.image_flash);
    CHECK(shot.flashes->misassignment_probability < 1e-3);
    CHECK(shot.flashes->first == made.image_flash.front() && shot.flashes->last == made.image_flash.back());
    CHECK_FALSE(shot.flags.has(reduction::Flag::flash_index_ambiguous));
  }
}

TEST(CodedPhotograph, OfACodeThatRepeatsWithinThePhotographIsFlaggedAndCounts) {
  Scenario coded;
  coded.intervals_s = {3.0e-3, 3.3e-3};  // the same again every 6.3 ms
  const SyntheticShot made = make_shot(coded);
  const auto result = host::shot_readout(made.shot, made.frame, settings).readout;
  CHECK(result.flags.has(reduction::Flag::flash_index_ambiguous));
  CHECK(result.flashes->coded &&
        result.flashes->misassignment_probability > matching::kMaxMisassignmentProbability);
  CHECK_FALSE(host::rejection_reason(result).has_value());
}

TEST(CodedPhotograph, IsToldAlsoWhereTheMachineWasFarOffItsLag) {
  settings.machine_lag_s = kMachineLag_s;
  Scenario even, omitted;
  even.machine_error_s = omitted.machine_error_s = 0.015;
  even.flash_count = 160;
  omitted.flash_count = 160;
  // One flash in eleven and one in thirteen left out: which gap is where is the same again only after 143.
  for (int k = 5; k < 200; k += 11) omitted.omitted.insert(k);
  for (int k = 8; k < 200; k += 13) omitted.omitted.insert(k);
  const SyntheticShot made_even = make_shot(even), made = make_shot(omitted);
  CHECK_FALSE(flashes_of(assembled(made_even)) == made_even.image_flash);  // follows the machine's lag
  CHECK(flashes_of(assembled(made)) == made.image_flash);
}

TEST(CodedPhotograph, GivesTheSameNumbersAsAnEvenOne) {
  Scenario coded;
  coded.intervals_s = {3.0e-3, 3.3e-3, 2.8e-3, 3.6e-3};
  const SyntheticShot made = make_shot(coded);
  const auto result = host::shot_readout(made.shot, made.frame, settings).readout;
  const auto near = [&](reduction::Quantity quantity, double truth) {
    CHECK(std::abs(*result.value[quantity] - truth) < 5.0 * *result.sd[quantity]);
  };
  near(reduction::Quantity::vx_td_mps, coded.bounce.vx_td);
  near(reduction::Quantity::vy_lo_mps, coded.bounce.vy_lo);
  near(reduction::Quantity::dwell_time_ms, coded.bounce.dwell_s * 1e3);
}

TEST(CodedPhotograph, ShowsAShutterThatDidNotTell) {
  SyntheticShot made = make_shot({});
  made.shot.shutter_feedback = strobe_msgs::shot_t::FEEDBACK_SEEN;
  CHECK_FALSE(assembled(made).flags.has(reduction::Flag::shutter_suspect));
  made.shot.shutter_feedback = strobe_msgs::shot_t::FEEDBACK_MISSING;
  CHECK(assembled(made).flags.has(reduction::Flag::shutter_suspect));
  made.shot.shutter_feedback = strobe_msgs::shot_t::FEEDBACK_LATE;
  CHECK(assembled(made).flags.has(reduction::Flag::shutter_suspect));
}

TEST_GROUP(DelayCalibrationOfAShot) { strobe_msgs::shot_t shot = make_shot({}).shot; };

TEST(DelayCalibrationOfAShot, GivesEachLampItsMeanAndItsUncertainty) {
  for (std::size_t k = 0; k < shot.flashes.size(); ++k) {
    auto& flash = shot.flashes[k];
    flash.observed_a_ns = flash.issue_end_ns + 12'000 + (k % 2 == 0 ? 100 : -100);
    flash.observed_b_ns = flash.issue_end_ns + 15'000;
  }
  const auto calibration = host::delay_calibration(shot);
  LONGS_EQUAL(166, calibration.lamp_a_us->count);
  DOUBLES_EQUAL(12.0, calibration.lamp_a_us->mean, 1e-9);
  // Half of them 0.1 above, half below: sd 0.1 sqrt(166/165).
  DOUBLES_EQUAL(0.1003, calibration.lamp_a_us->sd, 1e-4);
  DOUBLES_EQUAL(0.1003 / std::sqrt(166.0), calibration.lamp_a_us->mean_sd, 1e-5);
  DOUBLES_EQUAL(15.0, calibration.lamp_b_us->mean, 1e-9);
  CHECK_FALSE(calibration.opening_lag_ms.has_value());
  const auto lines = host::calibration_lines(calibration);
  STRCMP_EQUAL("[lamps]", lines.at(0).c_str());
  STRCMP_EQUAL("delay_a_us = 12.000    # +- 0.008 (mean of 166 flashes; 0.10 from flash to flash)",
               lines.at(1).c_str());
  STRCMP_CONTAINS("delay_b_us = 15.000", lines.at(2).c_str());
}

TEST(DelayCalibrationOfAShot, LeavesOutWhatDoesNotTell) {
  for (auto& flash : shot.flashes) {
    flash.observed_a_ns = flash.issue_end_ns + 12'000;
    flash.lamps = 1;  // lamp B was not asked, whatever its sensor saw
  }
  shot.flashes[3].issue_end_ns += 10'000'000;  // the machine stood still within the call
  shot.flashes[4].observed_a_ns += 500'000;    // the second of two flashes
  shot.flashes[4].extra_edges = 1;
  const auto calibration = host::delay_calibration(shot);
  LONGS_EQUAL(164, calibration.lamp_a_us->count);
  DOUBLES_EQUAL(12.0, calibration.lamp_a_us->mean, 1e-9);
  CHECK_FALSE(calibration.lamp_b_us.has_value());
}

TEST(DelayCalibrationOfAShot, TakesTheShuttersLagFromItsContact) {
  shot.shutter_feedback = strobe_msgs::shot_t::FEEDBACK_SEEN;
  shot.shutter_on_ns = 1'000'000'000;
  shot.shutter_open_ns = 1'046'000'000;
  shot.shutter_off_ns = 1'500'000'000;
  shot.shutter_close_ns = 1'545'000'000;
  const auto lines = host::calibration_lines(host::delay_calibration(shot));
  STRCMP_EQUAL("lag_ms = 45.50    # +- 0.50 (opened after 46.00, closed after 45.00)", lines.back().c_str());
}

TEST(DelayCalibrationOfAShot, ATrainOfSingleLampsIsSoundWhenEachSensorSawItsOwn) {
  for (std::size_t k = 0; k < shot.flashes.size(); ++k) {
    auto& flash = shot.flashes[k];
    flash.lamps = k % 2 == 0 ? 1 : 2;
    (k % 2 == 0 ? flash.observed_b_ns : flash.observed_a_ns) = strobe_msgs::flash_t::NO_TIME;
  }
  const auto report = host::train_report(shot);
  LONGS_EQUAL(83, report.planned_a);
  LONGS_EQUAL(83, *report.seen_by_a);
  LONGS_EQUAL(83, *report.seen_by_b);
  LONGS_EQUAL(0, report.skew_us.count);
  CHECK(host::sound(report));
  shot.flashes[10].observed_a_ns = strobe_msgs::flash_t::NO_TIME;
  CHECK_FALSE(host::sound(host::train_report(shot)));
}
