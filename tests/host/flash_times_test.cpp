#include "host/assembly/flash_times.hpp"

#include <cmath>
#include <limits>
#include <random>

#include "tests/host/synthetic_shot.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using strobe::from_ns;
using strobe::host::flash_times;
using strobe::host::FlashTimes;
using strobe_msgs::flash_t;
using strobe_msgs::shot_t;

flash_t flash(int index, std::int64_t commanded_ns, std::int64_t a_ns, std::int64_t b_ns) {
  flash_t f{};
  f.flash_index = index;
  f.lamps = 3;
  f.commanded_ns = commanded_ns;
  f.issue_start_ns = commanded_ns;
  f.issue_end_ns = commanded_ns + 100;
  f.observed_a_ns = a_ns;
  f.observed_b_ns = b_ns;
  return f;
}

constexpr std::int64_t kNone = flash_t::NO_TIME;

}  // namespace

TEST_GROUP(FlashTimesOfAShot) {
  shot_t shot{};

  void setup() override {
    shot.sensor_a_fitted = shot.sensor_b_fitted = true;
    shot.lamp_delay_a_us = shot.lamp_delay_b_us = 12.0;
    shot.late_tolerance_us = 100.0;
  }
};

TEST(FlashTimesOfAShot, MeanOfBothSensors) {
  shot.flashes = {flash(0, 1'000'000, 1'012'000, 1'013'000)};
  const FlashTimes times = flash_times(shot);
  CHECK_EQUAL(from_ns(1'012'500), times.seen[0].time);
  CHECK_FALSE(times.seen[0].late);
  CHECK_FALSE(times.seen[0].sensor_silent);
  CHECK_TRUE(times.measured);
}

TEST(FlashTimesOfAShot, TheSensorThatFiredCountsAloneAndTheOtherIsMissed) {
  shot.flashes = {flash(0, 1'000'000, kNone, 1'013'000), flash(1, 4'000'000, 4'011'000, kNone)};
  const FlashTimes times = flash_times(shot);
  CHECK_EQUAL(from_ns(1'013'000), times.seen[0].time);
  CHECK_EQUAL(from_ns(4'011'000), times.seen[1].time);
  CHECK_TRUE(times.seen[0].sensor_silent);
  CHECK_TRUE(times.seen[1].sensor_silent);
}

TEST(FlashTimesOfAShot, ASensorThatIsNotFittedIsNotMissed) {
  shot.sensor_a_fitted = false;
  shot.flashes = {flash(0, 1'000'000, kNone, 1'013'000)};
  CHECK_FALSE(flash_times(shot).seen[0].sensor_silent);
}

TEST(FlashTimesOfAShot, LatenessIsBeyondTheLampsDelayAndTheTolerance) {
  shot.flashes = {flash(0, 1'000'000, 1'112'000, 1'112'000),   // exactly the tolerance
                  flash(1, 4'000'000, 4'112'010, 4'112'010)};  // 10 ns more
  const FlashTimes times = flash_times(shot);
  CHECK_FALSE(times.seen[0].late);
  CHECK_TRUE(times.seen[1].late);
}

TEST(FlashTimesOfAShot, AFlashThatNoSensorSawIsMissing) {
  shot.flashes = {flash(0, 1'000'000, 1'012'000, 1'012'000), flash(1, 4'000'000, kNone, kNone),
                  flash(2, 7'000'000, 7'012'000, 7'012'000)};
  const FlashTimes times = flash_times(shot);
  LONGS_EQUAL(2, times.seen.size());
  LONGS_EQUAL(1, times.missing.size());
  LONGS_EQUAL(1, times.missing[0]);
}

TEST(FlashTimesOfAShot, WithoutAnySensorIssuedTimesAndTheLampsDelayHaveToDo) {
  shot.flashes = {flash(0, 1'000'000, kNone, kNone), flash(1, 4'000'000, kNone, kNone)};
  shot.flashes[1].issue_start_ns = shot.flashes[1].issue_end_ns = kNone;  // never issued
  const FlashTimes times = flash_times(shot);
  CHECK_FALSE(times.measured);
  LONGS_EQUAL(1, times.seen.size());
  CHECK_EQUAL(from_ns(1'012'100), times.seen[0].time);
  DOUBLES_EQUAL(20e-6, times.seen[0].time_sd_s, 1e-12);
  LONGS_EQUAL(1, times.missing[0]);
}

TEST(FlashTimesOfAShot, AFlashOfOneLampIsWhenItsOwnSensorSawIt) {
  shot.flashes = {flash(0, 1'000'000, 1'012'000, 1'015'000), flash(1, 4'000'000, 4'012'000, 4'016'000)};
  shot.flashes[0].lamps = 1;
  shot.flashes[1].lamps = 2;
  const FlashTimes times = flash_times(shot);
  CHECK_EQUAL(from_ns(1'012'000), times.seen[0].time);
  CHECK_EQUAL(from_ns(4'016'000), times.seen[1].time);
}

TEST(FlashTimesOfAShot, AFlashOfOneLampIsNotMissedByTheOthersSensor) {
  shot.flashes = {flash(0, 1'000'000, 1'012'000, kNone), flash(1, 4'000'000, kNone, 4'012'000),
                  flash(2, 7'000'000, kNone, 7'012'000)};
  shot.flashes[0].lamps = 1;
  shot.flashes[1].lamps = 2;
  shot.flashes[2].lamps = 1;  // lamp A alone, and its sensor did not see it
  const FlashTimes times = flash_times(shot);
  CHECK_FALSE(times.seen[0].sensor_silent);
  CHECK_FALSE(times.seen[1].sensor_silent);
  CHECK_TRUE(times.seen[2].sensor_silent);
}

TEST(FlashTimesOfAShot, EachLampHasItsOwnDelay) {
  shot.lamp_delay_a_us = 10.0;
  shot.lamp_delay_b_us = 150.0;
  shot.flashes = {flash(0, 1'000'000, kNone, 1'150'000), flash(1, 4'000'000, 4'111'000, kNone)};
  shot.flashes[0].lamps = 2;
  shot.flashes[1].lamps = 1;
  const FlashTimes times = flash_times(shot);
  CHECK_FALSE(times.seen[0].late);
  CHECK_TRUE(times.seen[1].late);
  shot.flashes = {flash(0, 1'000'000, kNone, kNone), flash(1, 4'000'000, kNone, kNone)};
  shot.flashes[1].lamps = 2;
  const FlashTimes unseen = flash_times(shot);
  CHECK_EQUAL(from_ns(1'000'100 + 80'000), unseen.seen[0].time);
  CHECK_EQUAL(from_ns(4'000'100 + 150'000), unseen.seen[1].time);
}

TEST(FlashTimesOfAShot, OneSensorForBothLampsAllowsForTheOthersDelay) {
  shot.lamp_delay_a_us = 10.0;
  shot.lamp_delay_b_us = 30.0;
  shot.sensor_b_fitted = false;
  shot.flashes = {flash(0, 1'000'000, 1'010'000, kNone)};
  CHECK_EQUAL(from_ns(1'020'000), flash_times(shot).seen[0].time);
  shot.sensor_b_fitted = true;  // it was silent: lamp B may not have flashed at all
  CHECK_EQUAL(from_ns(1'010'000), flash_times(shot).seen[0].time);
}

TEST(FlashTimesOfAShot, LightBeforeThePulseIsNotPlausible) {
  shot.flashes = {flash(0, 1'000'000, 980'000, 980'000)};
  CHECK_TRUE(flash_times(shot).seen[0].before_its_pulse);
}

TEST(FlashTimesOfAShot, TimesOutOfOrderAreNoticed) {
  shot.flashes = {flash(0, 1'000'000, 9'012'000, kNone), flash(1, 4'000'000, 4'012'000, kNone)};
  CHECK_FALSE(flash_times(shot).in_order);
}

TEST(FlashTimesOfAShot, ALampDelayThatIsNotANumberCountsAsNone) {
  shot.lamp_delay_a_us = shot.lamp_delay_b_us = std::numeric_limits<double>::quiet_NaN();
  shot.flashes = {flash(0, 1'000'000, kNone, kNone)};
  CHECK_EQUAL(from_ns(1'000'100), flash_times(shot).seen[0].time);
}

TEST_GROUP(FlashTimeSd) {
  shot_t shot{};

  /// A hundred flashes of which the lamp lets each wait by its own time, normal with 1 us, and every tenth far longer.
  void setup() override {
    shot.sensor_a_fitted = shot.sensor_b_fitted = true;
    std::mt19937 generator(3);
    std::normal_distribution<double> jitter_ns(0.0, 1000.0);
    for (int k = 0; k < 100; ++k) {
      const std::int64_t pulse = 1'000'000 + 1'500'000 * k + (k % 3) * 700;  // wherever the pulse was
      const std::int64_t seen =
          pulse + 12'000 + std::llround(jitter_ns(generator)) + (k % 10 == 0 ? 90'000 : 0);
      shot.flashes.push_back(flash(k, pulse, seen, seen));
    }
  }
};

TEST(FlashTimeSd, IsNoLargerThanWhatPulsesAndStampsAreApartBy) {
  const FlashTimes times = flash_times(shot);
  // A tenth far off makes the median absolute deviation larger by a seventh; of a hundred its sd is 0.12 of it.
  DOUBLES_EQUAL(1.14e-6, times.seen.front().time_sd_s, 3 * 0.12e-6);
  DOUBLES_EQUAL(times.seen.front().time_sd_s, times.seen.back().time_sd_s, 0.0);
}

TEST(FlashTimeSd, IsTheRigFilesWhereThatStatesIt) {
  DOUBLES_EQUAL(5e-6, flash_times(shot, 5e-6).seen.front().time_sd_s, 0.0);
}

TEST(FlashTimeSd, OfFewFlashesOrLampsThatWaitDifferentlyIsTheDefault) {
  for (flash_t& flash : shot.flashes) flash.observed_b_ns += flash.flash_index % 2 == 0 ? 30'000 : 0;
  DOUBLES_EQUAL(strobe::host::kSensorTimeSd_s, flash_times(shot).seen.front().time_sd_s, 0.0);
  shot.flashes.resize(33);
  for (flash_t& flash : shot.flashes) flash.observed_a_ns = flash.observed_b_ns = flash.issue_end_ns + 12'000;
  DOUBLES_EQUAL(strobe::host::kSensorTimeSd_s, flash_times(shot).seen.front().time_sd_s, 0.0);
  shot.flashes.push_back(shot.flashes.back());
  DOUBLES_EQUAL(strobe::host::kMinSensorTimeSd_s, flash_times(shot).seen.front().time_sd_s, 0.0);
}
