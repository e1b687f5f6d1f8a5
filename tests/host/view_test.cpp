// What a person reads: numbers with their uncertainties, what is missing, the series.
#include <limits>
#include <string>

#include "host/session/shot.hpp"
#include "host/view/render.hpp"
#include "host/view/spatial_view.hpp"
#include "host/text/text.hpp"
#include "host/view/timing.hpp"
#include "tests/host/rendered_rows.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using host::render;
using host::Shot;
using host::ViewModel;
using reduction::Flag;
using reduction::Quantity;
using strobe::testing::row;

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

Shot example(int id = 4, double vx = 15.6234) {
  Shot shot_result;
  shot_result.shot_id = id;
  shot_result.readout.shot_id = id;
  shot_result.readout.value[Quantity::vx_td_mps] = vx;
  shot_result.readout.sd[Quantity::vx_td_mps] = 0.0367;
  shot_result.readout.sd_systematic[Quantity::vx_td_mps] = 0.189;
  shot_result.readout.value[Quantity::e] = 0.8359;
  shot_result.readout.sd[Quantity::e] = 0.0024;
  shot_result.readout.regime = Regime::grips;
  return shot_result;
}

strobe_msgs::status_t idle() {
  strobe_msgs::status_t status{};
  status.state = strobe_msgs::status_t::IDLE;
  status.key_active = true;
  status.real_time = true;
  strobe_msgs::histogram_t lateness{};
  lateness.quantity = strobe_msgs::histogram_t::LATENESS;
  lateness.count = 166;
  lateness.mean_us = 0.0154, lateness.sd_us = 0.02, lateness.min_us = 0.0, lateness.p50_us = 0.0123;
  lateness.p99_us = 0.5, lateness.p999_us = 2.0;
  lateness.max_us = std::numeric_limits<double>::quiet_NaN();
  lateness.bin_first_us = -0.1, lateness.bin_width_us = 0.1;
  lateness.bins = {0, 128, 1, 11}, lateness.bin_count = 4;
  status.histograms = {lateness}, status.histogram_count = 1;
  return status;
}

/// As the model has it, with a scale error of 0.02 m/s and an expanded uncertainty to be seen.
host::Shot shot_of(const Shot& result) {
  host::Shot shot;
  shot.name = std::to_string(result.shot_id);
  shot.readout = result.readout;
  reduction::BudgetSource scale{.source = reduction::Source::scale, .input_sd = 0.1, .input_unit = "%"};
  scale.effect[static_cast<std::size_t>(Quantity::vx_td_mps)] = 0.02;
  shot.budget.sources = {scale};
  return shot;
}

ViewModel model() {
  ViewModel m;
  m.title = "strobe live   rig bench";
  m.status = idle();
  m.last = example();
  m.series.add(shot_of(*m.last));
  return m;
}

}  // namespace

TEST_GROUP(ScreenLines) { ViewModel m = model(); };

// Total of the shot: 0.0367 and 0.189 together, 0.1925. Of the series: mean of 15.6234 and 15.7, scatter (n - 1) 0.0542,
// standard error 0.0383, with the scale's 0.02 a total of 0.0432. Freedom 1 * (0.0432 / 0.0383)^4 = 1.62, whose Student's
// t is 5.43: 0.235 (12.7 of one degree, 4.3 of two).
TEST(ScreenLines, ShowTheShotWithItsTotalUncertaintyBesideTheSeries) {
  m.series.add(shot_of(example(5, 15.7)));
  const auto lines = render(m, 120);
  STRCMP_CONTAINS("shot 4 grips series of 2 shots", row(lines, "shot 4").c_str());
  CHECK_EQUAL("vx touchdown 15.62 ± 0.19 m/s 15.662 0.235 0.054 0.038 0.020 2", row(lines, "vx touchdown"));
  STRCMP_CONTAINS("0.8359 ± 0.0024", row(lines, "restitution e").c_str());
  CHECK_EQUAL("impulse ratio mu - -", row(lines, "impulse ratio mu"));
}

TEST(ScreenLines, ShowExpertsNumbersOnlyIfAsked) {
  m.last->readout.value[Quantity::slip_lo_mps] = 0.5;
  CHECK_EQUAL("", row(render(m, 120), "slip"));
  CHECK_EQUAL("", row(render(m, 160), "lateness"));
  m.all = true;
  CHECK_TRUE(!row(render(m, 120), "slip").empty());
  CHECK_TRUE(!row(render(m, 160), "lateness").empty());
  // What the total is made of, and 1.96 of it.
  CHECK_EQUAL("vx touchdown 15.62 ± 0.19 m/s ± 0.04 ± 0.19 ± 0.38",
              row(host::render_shot(*m.last, 120, true), "vx touchdown"));
}

// Total sds: hypot(0.3, 0.4) is 0.5 of the tilt; a tilt of one degree or less is told where it is flagged only.
TEST(ScreenLines, TellOfATiltedAxisAndAPathOutOfThePlaneOnlyWhereTheyAreNotZeroWithinTheirDoubt) {
  using reduction::SpatialQuantity;
  CHECK_EQUAL("", row(render(m, 120), "spin axis"));
  reduction::Spatial& spatial = m.last->readout.spatial.emplace();
  spatial[SpatialQuantity::omega_x_td_radps] = {-40.12, 1.2, 0.0};
  spatial[SpatialQuantity::omega_y_td_radps] = {0.5, 0.8, 0.0};
  spatial[SpatialQuantity::omega_z_td_radps] = {185.3, 0.6, 0.0};
  spatial[SpatialQuantity::spin_axis_tilt_td_deg] = {12.25, 0.3, 0.4};
  spatial[SpatialQuantity::vz_td_mps] = {0.2, 0.1, 0.0};
  CHECK_EQUAL("spin axis 12.25 ± 0.50 deg off the camera's, omega (x, y, z) (-40.1 ± 1.2, 0.50 ± 0.80, 185.30 ± "
              "0.60) rad/s at touchdown",
              row(render(m, 160), "spin axis"));
  CHECK_EQUAL("", row(render(m, 160), "towards the camera"));
  CHECK_EQUAL("", row(host::render_shot(*m.last, 160), "spin x touchdown"));
  CHECK_EQUAL("spin x touchdown -40.1 ± 1.2 rad/s ± 1.2 ± 0.0 ± 2.4",
              row(host::render_shot(*m.last, 160, true), "spin x touchdown"));
  CHECK_EQUAL("", row(host::render_shot(*m.last, 160, true), "spin x lift-off"));
  spatial[SpatialQuantity::spin_axis_tilt_td_deg] = {0.9, 0.3, 0.0};
  CHECK_EQUAL("", row(render(m, 160), "spin axis"));
  CHECK_EQUAL("", host::spin_drawing(m.last->readout));
  m.last->readout.flags.set(Flag::axis_tilted);
  STRCMP_CONTAINS("0.90 ± 0.30 deg", row(render(m, 160), "spin axis").c_str());
  spatial[SpatialQuantity::spin_axis_tilt_td_deg] = {0.9, 0.5, 0.0};
  CHECK_EQUAL("", row(render(m, 160), "spin axis"));
  spatial[SpatialQuantity::vz_lo_mps] = {-0.4, 0.1, 0.0};
  spatial[SpatialQuantity::off_plane_mm] = {-12.0, 3.0, 0.0};
  CHECK_EQUAL("towards the camera 0.20 ± 0.10 m/s at touchdown; -0.40 ± 0.10 m/s at lift-off; -12.0 ± 3.0 mm before "
              "the calibrated plane",
              row(render(m, 160), "towards the camera"));
}

TEST(ScreenLines, ShowTheCourtPaceOfShotsThatConformOnly) {
  m.last->readout.value[Quantity::court_pace] = 37.0;
  CHECK_EQUAL("", row(host::render_shot(*m.last, 120), "court pace"));
  STRCMP_CONTAINS("court pace indicative", host::render_shot(*m.last, 120, true).front().c_str());
  m.last->readout.court_pace_conforming = true;
  STRCMP_CONTAINS("37", row(host::render_shot(*m.last, 120), "court pace").c_str());
}

TEST(ScreenLines, SayWhatTheFirmwareIsDoing) {
  m.all = true;
  const auto lines = render(m, 160);
  STRCMP_CONTAINS("firmware idle key on e-stop released real time yes", row(lines, "firmware").c_str());
  CHECK_EQUAL("timing, us mean sd min p50 p99 p99.9 max n", row(lines, "timing"));
  // Eighths of ln n / ln 128, the rarest still one: 128 is all, 1 the least, 11 half.
  CHECK_EQUAL("lateness 0.02 0.02 0.00 0.01 0.50 2.00 - 166 -0.1 [ █▁▄] 0.3", row(lines, "lateness"));
  m.status->state = strobe_msgs::status_t::ARMED;
  m.status->mono_ns = 100;
  m.status->arm_expires_ns = 100 + 21'400'000'000;
  STRCMP_CONTAINS("ARMED, for 21 s more", row(render(m, 120), "firmware").c_str());
  m.status->estop_active = true;
  m.status->key_active = false;
  STRCMP_CONTAINS("key OFF e-stop PRESSED", row(render(m, 120), "firmware").c_str());
}

TEST(ScreenLines, SayHowTheFirmwaresClockStands) {
  m.status_age_s = 0.21;
  CHECK_EQUAL("clock: heartbeat 0.2 s ago", row(render(m, 160), "clock"));
  m.clock.latency_s = 0.00012;
  m.clock.worst_latency_s = 0.0034;
  m.clock.drift_ppm = 12.3456;
  CHECK_EQUAL("clock: heartbeat 0.2 s ago, +0.12 ms after the fastest; worst +3.40 ms drift 12.3 ppm",
              row(render(m, 160), "clock"));
  m.clock.suspect = true;
  STRCMP_CONTAINS("SUSPECT", row(render(m, 160), "clock").c_str());
}

TEST(ScreenLines, SayWhichCommandsWereIgnored) {
  m.status->rejected_forged = 3;
  m.status->rejected_replayed = 1;
  CHECK_EQUAL("lost events: queue 0, kernel 0, link 0 commands ignored: 3 forged, 1 replayed",
              row(render(m, 160), "lost"));
}

TEST(ScreenLines, SayWhichPacketsWereNotTheLabsOrThatNobodyKnows) {
  CHECK_EQUAL("", row(render(m, 160), "packets ignored"));
  m.unverified[strobe::authentication::Unverified::unsealed] = 12;
  m.unverified[strobe::authentication::Unverified::altered] = 1;
  CHECK_EQUAL("packets ignored: 12 not sealed, 1 altered", row(render(m, 160), "packets ignored"));
  CHECK_EQUAL("", row(render(m, 160), "UNVERIFIED"));
  m.verified = false;
  CHECK_EQUAL("UNVERIFIED: without the lab's key, anybody's messages are shown",
              row(render(m, 160), "UNVERIFIED"));
}

TEST(ScreenLines, TellAProgramTheSame) {
  m.status->boot_id = 0x2a;
  m.status->rejected_forged = 3, m.status->rejected_other_rig = 1;
  m.unverified[strobe::authentication::Unverified::altered] = 2;
  const std::string line = timing_json(*m.status, m.clock, 4, m.unverified);
  STRCMP_CONTAINS("{\"timing_after_shot\":4,\"boot_id\":\"2a\",\"timing\":{\"lateness_us\":{\"n\":166,",
                  line.c_str());
  STRCMP_CONTAINS("\"max\":null,\"bin_first\":-0.1,\"bin_width\":0.1,\"bins\":[0,128,1,11]}", line.c_str());
  STRCMP_CONTAINS("\"skew_us\":null", line.c_str());
  STRCMP_CONTAINS("\"drift_ppm\":null,\"latency_s\":null", line.c_str());
  STRCMP_CONTAINS(
      "\"rejected\":{\"malformed\":0,\"oversized\":0,\"forged\":3,\"replayed\":0,\"stale\":0,"
      "\"other_rig\":1},\"unverified\":{\"unsealed\":0,\"other_key\":0,\"altered\":2,\"replayed\":0}}",
      line.c_str());
  CHECK_EQUAL(std::string::npos, line.find('\n'));
}

TEST(ScreenLines, SayWhyNothingCanBeFired) {
  CHECK_EQUAL("", row(render(m, 120), "cannot fire"));
  m.status->message = "the key is off";
  CHECK_EQUAL("cannot fire: the key is off", row(render(m, 120), "cannot fire"));
  m.blocking_reason = "another host has armed the rig";
  CHECK_EQUAL("cannot fire: another host has armed the rig", row(render(m, 120), "cannot fire"));
  m.blocking_reason.clear();
  m.status_age_s = 7;
  m.silent = true;
  STRCMP_CONTAINS("silent for 7 s", row(render(m, 120), "cannot fire").c_str());
  m.status.reset();
  CHECK_EQUAL("cannot fire: no firmware heard", row(render(m, 120), "cannot fire"));
}

TEST(ScreenLines, BeginWithDangerUntilItIsOver) {
  m.danger = "THE OUTPUTS MAY BE ACTIVE: no such device";
  m.silent = true;
  CHECK_EQUAL("!!! THE OUTPUTS MAY BE ACTIVE: no such device", render_firmware(m, 120).front());
  m.danger.clear();
  CHECK_EQUAL("", row(render(m, 120), "!!!"));
}

TEST(ScreenLines, GiveEveryFlagInWords) {
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    m = model();
    const auto flag = static_cast<Flag>(i);
    m.last->readout.flags.set(flag);
    CHECK_FALSE(host::words(flag).empty());
    STRCMP_CONTAINS(std::string(host::words(flag)).c_str(), joined(render(m, 150)).c_str());
  }
}

TEST(ScreenLines, NameTheLikelyCauseOfFlags) {
  m.last->readout.likely_cause = reduction::LikelyCause{reduction::Cause::air, 0.04, 0.03};
  CHECK_EQUAL("! likely cause: the air; with drag and lift 0.04 ± 0.03 times those assumed all agrees",
              row(render(m, 150), "! likely"));
  for (const auto cause : {reduction::Cause::scale, reduction::Cause::ball_diameter, reduction::Cause::inclination,
                           reduction::Cause::flash_period}) {
    m.last->readout.likely_cause = reduction::LikelyCause{cause, -1.234, 0.012};
    STRCMP_CONTAINS("-1.23 ± 0.01 ", row(render(m, 150), "! likely").c_str());
  }
}

TEST(ScreenLines, ShowTheLaunchOfAFlightWithoutASurface) {
  Shot shot;
  reduction::Launch& launch = shot.readout.launch.emplace();
  launch.value[Quantity::v_td_mps] = 31.234;
  launch.sd[Quantity::v_td_mps] = 0.05;
  const auto lines = host::render_shot(shot, 120, false);
  CHECK_EQUAL("launch speed 31.234 ± 0.050 m/s", row(lines, "launch speed"));
  CHECK_EQUAL("launch spin - rad/s", row(lines, "launch spin"));
  CHECK_EQUAL("", row(lines, "restitution"));
}

TEST(ScreenLines, TellWhichFlashesOfACodedTrainShowTheBall) {
  m.all = true;
  m.last->readout.flashes = reduction::ImagedFlashes{25, 37, 0.99, false};
  CHECK_EQUAL("", row(render(m, 120), "code:"));
  m.last->readout.flashes = reduction::ImagedFlashes{25, 37, 0.000123, true};
  CHECK_EQUAL("code: flashes 25 to 37 show the ball; that it was others is 0.012 % probable",
              row(render(m, 120), "code:"));
  m.last->readout.flashes->misassignment_probability = 0.0;
  STRCMP_CONTAINS("is less than 0.01 % probable", row(render(m, 120), "code:").c_str());
}

TEST(ScreenLines, ARejectedShotWithoutNumbersSaysWhy) {
  m.last = Shot{};
  m.last->shot_id = 9;
  m.last->readout.flags.set(Flag::no_photograph);
  m.last->rejected = "the photograph did not come in time";
  m.last->problem = "no photograph within 5 s";
  const std::string text = joined(render(m, 120));
  STRCMP_CONTAINS("shot 9   REJECTED", text.c_str());
  STRCMP_CONTAINS("no photograph within 5 s", text.c_str());
  CHECK_EQUAL(std::string::npos, text.find("vx touchdown"));
}

TEST(ScreenLines, FitAnyWidthAndHoldNoEscapeCodes) {
  m.notifications = {
      "a notify with an umlaut ü and much too long a text for a narrow window, cut at its end"};
  m.last->readout.record["remarks"] = "\x1b[31mred";
  for (std::size_t width = 1; width <= 160; ++width) {
    for (const std::string& line : render(m, width)) {
      CHECK_TRUE(host::columns(line) <= width);
      CHECK_EQUAL(std::string::npos, line.find('\x1b'));
    }
  }
  STRCMP_CONTAINS("15.62", row(render(m, 60), "vx touchdown").c_str());
}

TEST(ScreenLines, ThesisRowsStandBesideTheSeries) {
  host::Series series;
  for (const double vx : {15.0, 16.0}) series.add(shot_of(example(1, vx)));
  thesis::Condition condition;
  condition.spin = "top";
  condition.angle_label_deg = 23;
  condition.vx_td_mps = {16.19, 0.23};
  const auto lines = host::render_series(series, condition, 160);
  STRCMP_CONTAINS("thesis top 23, Tables 3, 6, 9", joined(lines).c_str());
  // Two shots, 1 m/s apart: standard error 0.5, of which the scale's 0.02 is nothing; with a freedom of 1.003 Student's t is 12.6.
  // (15.5 - 16.19) / 0.23 = -3.0
  CHECK_EQUAL("vx touchdown m/s 15.50 6.31 0.50 0.71 0.50 0.02 2 16.19 ± 0.23 -3.0 sd",
              row(lines, "vx touchdown"));
}

TEST(ScreenLines, ASeriesWithoutShotsIsASentence) {
  host::Series series;
  CHECK_EQUAL(1U, host::render_series(series, std::nullopt, 120).size());
  CHECK_EQUAL("series: no shot counted yet", host::render_series(series, std::nullopt, 120).front());
  host::Shot shot = shot_of(example());
  shot.rejected = "no image of the ball";
  series.add(shot);
  CHECK_EQUAL("series: no shot counted: 1 rejected", host::render_series(series, std::nullopt, 120).front());
}

TEST(ScreenLines, ADryShotShowsItsTrain) {
  m.last = Shot{};
  m.last->shot_id = 2;
  m.last->dry = true;
  m.last->train.planned = m.last->train.issued = 166;
  m.last->train.seen_by_a = 165;
  const std::string text = joined(render(m, 140));
  STRCMP_CONTAINS("shot 2   dry", text.c_str());
  STRCMP_CONTAINS("flashes planned 166, issued 166, seen by sensor A 165, by sensor B not fitted",
                  text.c_str());
}

TEST_GROUP(TextForATerminal){};

TEST(TextForATerminal, IsCutAndPaddedByCharacters) {
  CHECK_EQUAL("±±…", host::cut("±±±±", 3));
  CHECK_EQUAL("±± ", host::left("±±", 3));
  CHECK_EQUAL(" ±±", host::right("±±", 3));
  CHECK_EQUAL("", host::cut("abc", 0));
  CHECK_EQUAL("a b", host::cut("a\tb", 9));
  LONGS_EQUAL(4, host::columns("aü日🎾"));
  STRCMP_EQUAL("日 ", host::left("日", 3).c_str());  // two columns wide
}

TEST(TextForATerminal, IsWrappedAtSpacesAndLosesNothing) {
  const std::vector<std::string> lines{"! ± one", "  two", "  threefour", "  five"};
  CHECK_TRUE(lines == host::wrapped("! ± one two threefour five", 7));
  CHECK_EQUAL("a b", host::wrapped("a b", 3).at(0));
  CHECK_EQUAL("", host::wrapped("", 0).at(0));
}

TEST(TextForATerminal, NumbersHaveTwoDigitsOfTheirUncertainty) {
  CHECK_EQUAL("15.623", host::rounded(15.6234, 0.0367));
  CHECK_EQUAL("-308", host::rounded(-307.9, 12.0));
  CHECK_EQUAL("-307.9", host::rounded(-307.91, 1.2));
  CHECK_EQUAL("1.000", host::rounded(1.0, 0.0));
}

TEST_GROUP(ViewModel){};

TEST(ViewModel, CountsEveryShotAndAddsToTheSeriesOnlyThoseThatCount) {
  ViewModel m;
  host::Shot result;
  m.add(result);
  result.dry = true;
  m.add(result);
  result.dry = false;
  result.rejected = "late";
  m.add(result);
  LONGS_EQUAL(3, m.shots);
  LONGS_EQUAL(1, m.series.counted());
  LONGS_EQUAL(1, m.series.rejected());
  STRCMP_EQUAL("late", m.last->rejected->c_str());
}

TEST(ViewModel, BeginsTheSeriesAnewWithAnotherCondition) {
  ViewModel m;
  Shot hard = example(1, 15.0), soft = example(3, 20.0);
  hard.readout.record["surface_name"] = "hard";
  soft.readout.record["surface_name"] = "soft";
  for (const Shot& shot : {hard, hard, soft}) m.add(shot);
  LONGS_EQUAL(3, m.shots);
  LONGS_EQUAL(1, m.series.counted());
  LONGS_EQUAL(1, m.notifications.size());
  const auto mean = m.series.summary("").quantities[static_cast<std::size_t>(Quantity::vx_td_mps)].mean;
  DOUBLES_EQUAL(20.0, mean, 0.0);
}

TEST(ViewModel, GoesOnWithTheSeriesAfterAShotOfWhichNothingIsKnown) {
  ViewModel m;
  Shot noted = example(1, 15.0), lost;
  noted.readout.record["surface_name"] = "hard";
  lost.rejected = "its end is in no log";
  for (const Shot& shot : {noted, lost, noted}) m.add(shot);
  LONGS_EQUAL(2, m.series.counted());
  LONGS_EQUAL(1, m.series.rejected());
  LONGS_EQUAL(0, m.notifications.size());
}

TEST(ViewModel, KeepsTheNewestFiftyNotifications) {
  ViewModel m;
  for (int i = 1; i <= 51; ++i) m.add_notification(std::to_string(i));
  LONGS_EQUAL(50, m.notifications.size());
  CHECK_EQUAL("2", m.notifications.front());
  CHECK_EQUAL("51", m.notifications.back());
}

TEST_GROUP(Verdict){};

TEST(Verdict, OnlyWhatInvalidatesTheNumbersIsFiredAgain) {
  for (const Flag flag : {Flag::shot_aborted, Flag::no_photograph, Flag::too_few_images, Flag::missing_flash,
                          Flag::double_flash, Flag::flash_match_ambiguous}) {
    reduction::Readout readout;
    readout.flags.set(flag);
    CHECK_TRUE(host::rejection_reason(readout).has_value());
  }
  for (const Flag flag : {Flag::late_flash, Flag::sensor_missing, Flag::outlier_image, Flag::no_contact_image,
                          Flag::sd_from_residuals, Flag::spin_aliased, Flag::events_missing,
                          Flag::no_redundancy, Flag::overlaps_surface}) {
    reduction::Readout readout;
    readout.flags.set(flag);
    CHECK_FALSE(host::rejection_reason(readout).has_value());
  }
}
