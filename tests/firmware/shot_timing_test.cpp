#include "firmware/core/shot_timing.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::firmware;

namespace {

constexpr MonoTime at_us(std::int64_t us) { return from_ns(us * 1000); }

}  // namespace

TEST_GROUP(ShotTiming) {
  ShotTiming timing;
  ShotRecord shot;

  FlashRecord& flash(std::int64_t commanded_us, std::int64_t issue_end_us) {
    FlashRecord flash;
    flash.commanded = at_us(commanded_us);
    flash.issue_start = at_us(issue_end_us - 1);
    flash.issue_end = at_us(issue_end_us);
    shot.flashes.push_back(flash);
    return shot.flashes.back();
  }
  const TimingHistogram& of(TimingQuantity quantity) { return timing.of(quantity); }
};

TEST(ShotTiming, ToldOfAnIssuedFlashCountsItsLatenessAndItsCall) {
  timing.issued(at_us(1000), at_us(1004), at_us(1005));
  CHECK_EQUAL(4000, of(TimingQuantity::lateness).max().count());
  CHECK_EQUAL(1000, of(TimingQuantity::issue).max().count());
  CHECK_EQUAL(0, of(TimingQuantity::skew).count());
}

TEST(ShotTiming, TakesSkewAndEachLampsDelayFromWhatTheSensorsSaw) {
  FlashRecord& both = flash(0, 2);
  both.observed_a = at_us(14);
  both.observed_b = at_us(17);
  flash(3000, 3002).observed_b = at_us(3014);
  timing.seen(shot);
  CHECK_EQUAL(1, of(TimingQuantity::skew).count());
  CHECK_EQUAL(-3000, of(TimingQuantity::skew).max().count());
  CHECK_EQUAL(1, of(TimingQuantity::lamp_delay_a).count());
  CHECK_EQUAL(12'000, of(TimingQuantity::lamp_delay_a).max().count());
  CHECK_EQUAL(2, of(TimingQuantity::lamp_delay_b).count());
  CHECK_EQUAL(12'000, of(TimingQuantity::lamp_delay_b).min().count());
}

TEST(ShotTiming, TakesALampsDelayOnlyFromItsOwnSensor) {
  FlashRecord& only_a = flash(0, 2);
  only_a.lamps = Lamps::a;
  only_a.observed_a = at_us(14);
  only_a.observed_b = at_us(15);  // it saw the other lamp's light
  timing.seen(shot);
  CHECK_EQUAL(1, of(TimingQuantity::lamp_delay_a).count());
  CHECK_EQUAL(0, of(TimingQuantity::lamp_delay_b).count());
  CHECK_EQUAL(0, of(TimingQuantity::skew).count());
}

TEST(ShotTiming, TakesThePeriodsErrorFromTheSensorsThatSawBothFlashes) {
  FlashRecord& first = flash(0, 2);
  first.observed_a = at_us(14);
  first.observed_b = at_us(94);  // a sensor that is 80 us slower
  FlashRecord& second = flash(3000, 3002);
  second.observed_a = at_us(3019);  // 5 us late
  second.observed_b = at_us(3097);  // 3 us late
  flash(6000, 6002).observed_b = at_us(6094);
  timing.seen(shot);
  CHECK_EQUAL(2, of(TimingQuantity::period_error).count());
  CHECK_EQUAL(4000, of(TimingQuantity::period_error).max().count());
  CHECK_EQUAL(-3000, of(TimingQuantity::period_error).min().count());
}

TEST(ShotTiming, AFlashThatNobodySawMakesNoPeriod) {
  flash(0, 2).observed_a = at_us(14);
  flash(3000, 3002);
  flash(6000, 6002).observed_a = at_us(6014);
  timing.seen(shot);
  CHECK_EQUAL(0, of(TimingQuantity::period_error).count());
}
