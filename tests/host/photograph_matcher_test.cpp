// Photographs to shots in virtual time: order, window, what is late, missing, extra or old.
#include "host/photographs/photograph_matcher.hpp"

#include <fmt/format.h>

#include <string>

#include <CppUTest/TestHarness.h>

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

/// Instants are seconds of the firmware's clock; photographs may come 5 s after their shot.
struct Bench {
  strobe::host::DeviceClock clock;
  PhotographMatcher match{clock, 5.0};

  Bench() { clock.on_heartbeat(7, {}, kStart); }
  void shot(int id, double closed_s, bool dry = false) {
    strobe_msgs::shot_t shot{};
    shot.boot_id = 7;
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

}  // namespace

TEST_GROUP(PhotographsToShots){};

TEST(PhotographsToShots, EachShotGetsTheOneThatFollowsIt) {
  Bench bench;
  bench.shot(1, 10.0);
  bench.photograph(1, 10.6);
  STRCMP_EQUAL("1>1", bench.decided(10.6).c_str());
  bench.shot(2, 14.0);
  bench.photograph(2, 14.6);
  STRCMP_EQUAL("2>2", bench.decided(14.6).c_str());
}

TEST(PhotographsToShots, APhotographMayBeHereBeforeTheWordOfItsShot) {
  Bench bench;
  bench.photograph(1, 10.6);
  STRCMP_EQUAL("", bench.decided(11.0).c_str());
  bench.shot(1, 10.0);
  STRCMP_EQUAL("1>1", bench.decided(11.1).c_str());
}

TEST(PhotographsToShots, OneBeforeTheShutterHasClosedIsNobodys) {
  Bench bench;
  bench.shot(1, 10.0);
  bench.photograph(1, 9.8);
  STRCMP_EQUAL("", bench.decided(10.5).c_str());
  STRCMP_EQUAL("1:no shot waits for a photograph: not used", bench.decided(15.0).c_str());
  bench.photograph(2, 10.9);
  STRCMP_EQUAL("2>1!", bench.decided(15.1).c_str());
}

TEST(PhotographsToShots, AnOldFileThatIsMovedIntoTheFolderIsNobodys) {
  Bench bench;
  bench.shot(1, 10.0);
  bench.photograph(1, 10.6, 3.0);
  STRCMP_EQUAL("1:its file is 6.5 s older than shot 1: not used", bench.left(11.0).c_str());
}

TEST(PhotographsToShots, AnExtraOneIsSaidAndHarmsNothing) {
  Bench bench;
  bench.shot(1, 10.0);
  bench.photograph(1, 10.6);
  bench.photograph(2, 11.0);
  STRCMP_EQUAL("1>1", bench.decided(11.0).c_str());
  bench.shot(2, 14.0);
  bench.photograph(3, 14.6);
  // The extra one came before shot 2 and blocks nobody for longer than it may wait for word of its shot.
  STRCMP_EQUAL("2:no shot waits for a photograph: not used 3>2", bench.decided(16.1).c_str());
}

TEST(PhotographsToShots, ALateOneIsKeptForItsShotWhileNoOtherWasExposed) {
  Bench bench;
  bench.shot(1, 10.0);
  bench.photograph(1, 17.0);
  STRCMP_EQUAL("1>1!", bench.decided(17.0).c_str());
}

TEST(PhotographsToShots, ALateOneIsNeverTakenForTheNextShots) {
  Bench bench;
  bench.shot(1, 10.0);  // whose photograph is late
  bench.shot(2, 16.0);
  bench.photograph(1, 16.3);
  STRCMP_EQUAL("", bench.decided(16.4).c_str());
  bench.photograph(2, 16.7);
  STRCMP_EQUAL("1>1! 2>2", bench.decided(16.7).c_str());
}

TEST(PhotographsToShots, AfterAMissingOneTheNextShotsIsTakenOnceNoOtherCame) {
  Bench bench;
  bench.shot(1, 10.0);
  bench.photograph(1, 10.6);
  STRCMP_EQUAL("1>1", bench.decided(10.6).c_str());
  bench.shot(2, 14.0);  // which gets none
  bench.shot(3, 20.0);
  bench.photograph(2, 20.6);
  STRCMP_EQUAL("", bench.decided(20.7).c_str());
  // Its own would have come by twice the usual 0.6 s and a fifth of a second.
  STRCMP_EQUAL("", bench.decided(21.39).c_str());
  STRCMP_EQUAL("2>3", bench.decided(21.41).c_str());
  bench.shot(4, 25.0);
  bench.photograph(3, 25.6);
  STRCMP_EQUAL("3>4", bench.decided(25.6).c_str());
}

TEST(PhotographsToShots, OfShotsInQuickSuccessionTheyComeInOrder) {
  Bench bench;
  bench.shot(1, 10.0);
  bench.shot(2, 11.0);
  bench.photograph(1, 12.0);
  STRCMP_EQUAL("", bench.decided(12.0).c_str());
  bench.photograph(2, 13.0);
  STRCMP_EQUAL("1>1 2>2", bench.decided(13.0).c_str());
}

TEST(PhotographsToShots, WhatMayBeOfEitherOfTwoShotsIsNobodys) {
  Bench bench;
  bench.shot(1, 10.0);
  bench.shot(2, 11.0);
  bench.photograph(1, 17.0);
  STRCMP_EQUAL("1:it came too late, of shot 1 or 2: not used", bench.decided(17.0).c_str());
}

TEST(PhotographsToShots, ADryShotTakesItsOwnUnmeasured) {
  Bench bench;
  bench.shot(1, 10.0, true);
  bench.photograph(1, 10.6);
  STRCMP_EQUAL("1>1~", bench.decided(10.6).c_str());
}

TEST(PhotographsToShots, OneThatSomebodyElseMeasuredIsNotWanted) {
  Bench bench;
  bench.shot(1, 10.0);
  bench.match.on_measured({7, 1});
  bench.photograph(1, 10.6);
  STRCMP_EQUAL("1>1~", bench.decided(10.6).c_str());
}

TEST(PhotographsToShots, AfterOneThatCannotBeReadAnotherMayCome) {
  Bench bench;
  bench.shot(1, 10.0);
  bench.photograph(1, 10.6);
  STRCMP_EQUAL("1>1", bench.decided(10.6).c_str());
  bench.match.give_back({7, 1});
  bench.photograph(2, 11.5);
  STRCMP_EQUAL("2>1", bench.decided(11.5).c_str());
}

TEST(PhotographsToShots, TheClockIsThatOfThePromptestMessage) {
  Bench bench;
  bench.clock.on_heartbeat(7, device(kSecond), kStart + 9 * kSecond);  // heard 8 s late
  bench.shot(1, 10.0);
  bench.photograph(1, 10.6);
  STRCMP_EQUAL("1>1", bench.decided(10.6).c_str());
}

TEST(PhotographsToShots, TheClockIsFollowedThroughDriftAndSuspension) {
  Bench bench;
  // 500 ppm for an hour: 1.8 s by its end. Then the firmware's machine sleeps for a minute.
  HostTime heard;
  Duration sent{};
  for (int i = 1; i <= 7200; ++i) {
    sent = i * kSecond / 2;
    heard = kStart + sent + sent / 2000;
    bench.clock.on_heartbeat(7, device(sent), heard);
  }
  bench.shot(1, 3599.5);
  const Duration minute = std::chrono::minutes{1};
  for (int i = 1; i <= 2; ++i)
    bench.clock.on_heartbeat(7, device(sent + i * kSecond, minute), heard + i * kSecond + minute);
  bench.shot(2, 3601.5);
  bench.match.on_photograph(1, heard + kSecond / 100, heard);
  bench.match.on_photograph(2, heard + 2 * kSecond + minute, heard + 2 * kSecond + minute);
  STRCMP_EQUAL("1>1! 2>2", Bench::words(bench.match.decide(heard + 2 * kSecond + minute)).c_str());
}
