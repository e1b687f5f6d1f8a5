// Photographs to shots in virtual time: order, window, what is late, missing, extra or old.
#include "host/photographs/photograph_matcher.hpp"

#include <fmt/format.h>

#include <string>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using strobe::host::PhotographDecision;
using strobe::host::PhotographMatcher;

constexpr Duration kSecond = std::chrono::seconds{1};
constexpr HostTime kStart{1000 * kSecond};  // when the firmware's clock is at 0

HostTime at(double seconds) { return kStart + from_seconds(seconds); }

/// The firmware's clocks, its machine having slept for so long.
host::DeviceReading device(Duration mono, Duration slept = {}) {
  return {MonoTime{mono}, WallTime{mono + slept}, mono + slept};
}

}  // namespace

/// Instants are seconds of the firmware's clock; photographs may come 5 s after their shot.
TEST_GROUP(PhotographsToShots) {
  strobe::host::DeviceClock clock;
  PhotographMatcher match{clock, 5.0};

  void setup() override { clock.on_heartbeat(7, {}, kStart); }
  void shot(int id, double closed_s, bool dry = false, std::int64_t boot_id = 7) {
    strobe_msgs::shot_t shot{};
    shot.boot_id = boot_id;
    shot.shot_id = id;
    shot.shutter_open_ns = static_cast<std::int64_t>((closed_s - 0.5) * 1e9);
    shot.shutter_close_ns = static_cast<std::int64_t>(closed_s * 1e9);
    shot.plan.dry = dry;
    match.on_shot(shot);
  }
  void photograph(int number, double arrived_s) { photograph(number, arrived_s, arrived_s); }
  void photograph(int number, double arrived_s, double written_s) {
    match.on_photograph(number, at(arrived_s), at(written_s));
  }
  /// Of a camera that tells when each exposure began.
  void stamped(int number, double arrived_s, double exposed_s, Duration sd = milliseconds{1}) {
    match.on_photograph(number, at(arrived_s), at(arrived_s), strobe::tether::ExposureStart{at(exposed_s), sd});
  }
  /// "photograph>shot", with ! for late ones and ~ for those not wanted; "photograph:why".
  std::string decided(double now_s) { return words(match.decide(at(now_s))); }
  std::string left(double now_s) { return words(match.end(at(now_s))); }

  static std::string words(const std::vector<PhotographDecision>& decisions) {
    std::string text;
    for (const auto& d : decisions) {
      const std::string shot =
          d.shot ? fmt::format(">{}{}{}", d.shot->shot_id, d.wanted ? "" : "~", d.late ? "!" : "")
                 : ":" + d.why;
      text += fmt::format("{}{}{}", text.empty() ? "" : " ", d.photograph, shot);
    }
    return text;
  }
};

TEST(PhotographsToShots, EachShotGetsTheOneThatFollowsIt) {
  shot(1, 10.0);
  photograph(1, 10.6);
  CHECK_EQUAL("1>1", decided(10.6));
  shot(2, 14.0);
  photograph(2, 14.6);
  CHECK_EQUAL("2>2", decided(14.6));
}

TEST(PhotographsToShots, APhotographMayBeHereBeforeTheWordOfItsShot) {
  photograph(1, 10.6);
  CHECK_EQUAL("", decided(11.0));
  shot(1, 10.0);
  CHECK_EQUAL("1>1", decided(11.1));
}

TEST(PhotographsToShots, OneBeforeTheShutterHasClosedIsNobodys) {
  shot(1, 10.0);
  photograph(1, 9.8);
  CHECK_EQUAL("", decided(10.5));
  CHECK_EQUAL("1:no shot waits for a photograph: not used", decided(15.0));
  photograph(2, 10.9);
  CHECK_EQUAL("2>1!", decided(15.1));
}

TEST(PhotographsToShots, AnOldFileThatIsMovedIntoTheFolderIsNobodys) {
  shot(1, 10.0);
  photograph(1, 10.6, 3.0);
  CHECK_EQUAL("1:its file is 6.5 s older than shot 1: not used", left(11.0));
}

TEST(PhotographsToShots, AnExtraOneIsSaidAndHarmsNothing) {
  shot(1, 10.0);
  photograph(1, 10.6);
  photograph(2, 11.0);
  CHECK_EQUAL("1>1", decided(11.0));
  shot(2, 14.0);
  photograph(3, 14.6);
  // The extra one came before shot 2 and blocks nobody for longer than it may wait for word of its shot.
  CHECK_EQUAL("2:no shot waits for a photograph: not used 3>2", decided(16.1));
}

TEST(PhotographsToShots, ALateOneIsKeptForItsShotWhileNoOtherWasExposed) {
  shot(1, 10.0);
  photograph(1, 17.0);
  CHECK_EQUAL("1>1!", decided(17.0));
}

TEST(PhotographsToShots, ALateOneIsNeverTakenForTheNextShots) {
  shot(1, 10.0);  // whose photograph is late
  shot(2, 16.0);
  photograph(1, 16.3);
  CHECK_EQUAL("", decided(16.4));
  photograph(2, 16.7);
  CHECK_EQUAL("1>1! 2>2", decided(16.7));
}

TEST(PhotographsToShots, AfterAMissingOneTheNextShotsIsTakenOnceNoOtherCame) {
  shot(1, 10.0);
  photograph(1, 10.6);
  CHECK_EQUAL("1>1", decided(10.6));
  shot(2, 14.0);  // which gets none
  shot(3, 20.0);
  photograph(2, 20.6);
  CHECK_EQUAL("", decided(20.7));
  // Its own would have come by twice the usual 0.6 s and a fifth of a second.
  CHECK_EQUAL("", decided(21.39));
  CHECK_EQUAL("2>3", decided(21.41));
  shot(4, 25.0);
  photograph(3, 25.6);
  CHECK_EQUAL("3>4", decided(25.6));
}

TEST(PhotographsToShots, OfACameraThatHasBeenSlowerThanItsTimeAreNeverGuessed) {
  shot(1, 10.0);
  photograph(1, 16.5);
  CHECK_EQUAL("1>1!", decided(16.5));
  shot(2, 20.0);
  shot(3, 31.0);
  photograph(2, 31.5);  // 11.5 s after shot 2, where 6.5 s have been seen: either's
  CHECK_EQUAL("", decided(35.9));
  CHECK_EQUAL("2:it came too late, of shot 2 or 3: not used", decided(36.1));
}

TEST(PhotographsToShots, OfShotsInQuickSuccessionTheyComeInOrder) {
  shot(1, 10.0);
  shot(2, 11.0);
  photograph(1, 12.0);
  CHECK_EQUAL("", decided(12.0));
  photograph(2, 13.0);
  CHECK_EQUAL("1>1 2>2", decided(13.0));
}

TEST(PhotographsToShots, WhatMayBeOfEitherOfTwoShotsIsNobodys) {
  shot(1, 10.0);
  shot(2, 11.0);
  photograph(1, 17.0);
  CHECK_EQUAL("1:it came too late, of shot 1 or 2: not used", decided(17.0));
}

TEST(PhotographsToShots, ADryShotTakesItsOwnUnmeasured) {
  shot(1, 10.0, true);
  photograph(1, 10.6);
  CHECK_EQUAL("1>1~", decided(10.6));
}

TEST(PhotographsToShots, OneThatSomebodyElseMeasuredIsNotWanted) {
  shot(1, 10.0);
  match.on_measured({7, 1});
  photograph(1, 10.6);
  CHECK_EQUAL("1>1~", decided(10.6));
}

TEST(PhotographsToShots, AfterOneThatCannotBeReadAnotherMayCome) {
  shot(1, 10.0);
  photograph(1, 10.6);
  CHECK_EQUAL("1>1", decided(10.6));
  match.give_back({7, 1});
  photograph(2, 11.5);
  CHECK_EQUAL("2>1", decided(11.5));
}

TEST(PhotographsToShots, TheClockIsThatOfThePromptestMessage) {
  clock.on_heartbeat(7, device(kSecond), kStart + 9 * kSecond);  // heard 8 s late
  shot(1, 10.0);
  photograph(1, 10.6);
  CHECK_EQUAL("1>1", decided(10.6));
}

TEST(PhotographsToShots, TheClockIsFollowedThroughDriftAndSuspension) {
  // 500 ppm for an hour: 1.8 s by its end. Then the firmware's machine sleeps for a minute.
  HostTime heard;
  Duration sent{};
  for (int i = 1; i <= 7200; ++i) {
    sent = i * kSecond / 2;
    heard = kStart + sent + sent / 2000;
    clock.on_heartbeat(7, device(sent), heard);
  }
  shot(1, 3599.5);
  const Duration minute = std::chrono::minutes{1};
  for (int i = 1; i <= 2; ++i)
    clock.on_heartbeat(7, device(sent + i * kSecond, minute), heard + i * kSecond + minute);
  shot(2, 3601.5);
  match.on_photograph(1, heard + kSecond / 100, heard);
  match.on_photograph(2, heard + 2 * kSecond + minute, heard + 2 * kSecond + minute);
  CHECK_EQUAL("1>1! 2>2", words(match.decide(heard + 2 * kSecond + minute)));
}

TEST(PhotographsToShots, OfBothBootsAreMatchedAfterTheFirmwaresMachineWasStartedAnew) {
  for (const double anew_s : {30.0, 90'000.0}) {  // its clock; or that of a machine that stands in for it
    host::DeviceClock clocks;
    PhotographMatcher matcher(clocks, 5.0);
    const auto of = [&matcher](std::int64_t boot_id, int id, double closed_s) {
      strobe_msgs::shot_t shot{};
      shot.boot_id = boot_id;
      shot.shot_id = id;
      shot.shutter_open_ns = static_cast<std::int64_t>((closed_s - 0.5) * 1e9);
      shot.shutter_close_ns = static_cast<std::int64_t>(closed_s * 1e9);
      matcher.on_shot(shot);
    };
    clocks.on_heartbeat(8, device(5000 * kSecond), at(5000.0));
    of(8, 1, 5000.0);  // its photograph takes its time
    clocks.on_heartbeat(7, device(from_seconds(anew_s)), at(5002.0));
    clocks.on_heartbeat(8, device(5001 * kSecond), at(5002.1));  // comes late
    matcher.on_photograph(1, at(5003.0), at(5003.0));
    CHECK_EQUAL("1>1", words(matcher.decide(at(5003.0))));
    of(7, 1, anew_s + 2.0);
    of(8, 2, 5001.0);  // fetched from the earlier boot's journal: closed before boot 7's
    matcher.on_photograph(2, at(5004.6), at(5004.6));
    matcher.on_photograph(3, at(5004.9), at(5004.9));
    const auto decisions = matcher.decide(at(5005.0));
    CHECK_EQUAL("2>2 3>1", words(decisions));
    LONGS_EQUAL(8, decisions[0].shot->boot_id);
    LONGS_EQUAL(7, decisions[1].shot->boot_id);
  }
}

TEST(PhotographsToShots, AreMatchedWhenTheClockOfTheirBootIsKnown) {
  photograph(1, 10.6);
  shot(1, 32.0, false, 8);
  CHECK_EQUAL("", decided(10.7));
  clock.on_heartbeat(8, device(32 * kSecond + kSecond / 2), at(10.8));
  CHECK_EQUAL("1>1", decided(10.9));
}

TEST(PhotographsToShots, StampedOnesAreOfTheShotWithinWhoseExposureTheyBeganInWhateverOrderTheyCome) {
  shot(1, 10.0);
  shot(2, 14.0);
  shot(3, 18.0);
  stamped(1, 18.4, 17.52);
  stamped(2, 18.5, 9.51);
  CHECK_EQUAL("1>3 2>1!", decided(18.6));
  stamped(3, 19.0, 13.50);
  CHECK_EQUAL("3>2", decided(19.0));
}

TEST(PhotographsToShots, AMissingOneShiftsNoStampedOne) {
  shot(1, 10.0);
  shot(2, 14.0);
  stamped(1, 14.2, 13.5);  // at once, where a file without a stamp would have to be waited with
  CHECK_EQUAL("1>2", decided(14.2));
}

TEST(PhotographsToShots, ASecondStampedOneOfAShotAndOneOfNoneAreTold) {
  shot(1, 10.0);
  stamped(1, 10.2, 9.5);
  stamped(2, 10.3, 9.5);
  stamped(3, 10.4, 7.0);
  CHECK_EQUAL("1>1 2:a second one of shot 1: not used", decided(10.4));
  CHECK_EQUAL("3:no shot's shutter was open when it was exposed: not used", decided(15.5));
}

TEST(PhotographsToShots, StampedOnesWaitForTheWordOfTheirShot) {
  stamped(1, 10.2, 9.5);
  CHECK_EQUAL("", decided(12.0));
  shot(1, 10.0);
  CHECK_EQUAL("1>1", decided(12.1));
}

TEST(PhotographsToShots, AStampThatIsKnownTooPoorlyIsNotGuessedBy) {
  shot(1, 10.0);
  shot(2, 12.0);
  stamped(1, 12.1, 10.4, std::chrono::seconds{1});
  CHECK_EQUAL("1:it may be of shot 1 or 2: not used", decided(12.2));
}
