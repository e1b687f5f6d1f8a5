#include "firmware/flash_sequencer/clock_relation.hpp"

#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {

using flash_sequencer::kTick_ns;
using flash_sequencer::Ticks;

/// A sequencer's clock that was started at some instant and is off by so much.
struct TrueClock {
  MonoTime started = from_ns(7'000'000'123);
  double drift = 37e-6;
  Duration stamps_late{};  ///< a request that has come, always
  Ticks ticks(MonoTime at) const {
    return static_cast<Ticks>(std::floor(static_cast<double>((at - started).count()) / kTick_ns * (1.0 - drift)));
  }
};

/// Errors of the relation, and those over the standard deviation that it states.
struct Score {
  double squares_ns2 = 0.0, normalized_squares = 0.0, largest_ns = 0.0;
  int count = 0;
  void add(double error_ns, double sd_ns) {
    squares_ns2 += error_ns * error_ns;
    normalized_squares += (error_ns / sd_ns) * (error_ns / sd_ns);
    largest_ns = std::max(largest_ns, std::abs(error_ns));
    ++count;
  }
  double rms_ns() const { return std::sqrt(squares_ns2 / count); }
  double normalized() const { return std::sqrt(normalized_squares / count); }
};

constexpr Duration kBeat = milliseconds(4);

}  // namespace

TEST_GROUP(ClockRelation) {
  std::mt19937_64 random{4711};
  TrueClock clock;
  ClockRelation relation;
  MonoTime now = from_ns(9'000'000'000);
  Duration stall_every{}, stall{};

  double exponential_ns(double mean_ns) { return std::exponential_distribution<double>(1.0 / mean_ns)(random); }
  /// The request takes so long on its way in the mean, its answer as long, both at least `least`.
  void beat(double mean_ns, Duration least = {}) {
    const auto delay = [&] {
      Duration taken = least + Duration{std::llround(exponential_ns(mean_ns))};
      if (stall > Duration{} && now.time_since_epoch() % stall_every < stall) taken += stall;
      return taken;
    };
    const MonoTime sent = now, received = sent + delay(), heard = received + delay();
    relation.observe(sent, clock.ticks(received + clock.stamps_late), heard);
    now += kBeat;
  }
  double error_ns(MonoTime at) { return static_cast<double>((relation.to_time(clock.ticks(at)) - at).count()); }
  double sd_ns(MonoTime at) { return static_cast<double>(relation.sd(clock.ticks(at)).count()); }
  /// Of the newest instant, once every 40 ms for so many seconds.
  Score score(int seconds, double mean_ns) {
    Score score;
    for (int beats = 0; beats < seconds * 250; ++beats) {
      beat(mean_ns);
      if (beats % 10 == 0) score.add(error_ns(now), sd_ns(now));
    }
    return score;
  }
};

TEST(ClockRelation, IsNotKnownBeforeTheFirstAnswer) {
  CHECK_FALSE(relation.known());
  beat(10e3);
  CHECK_TRUE(relation.known());
  relation.forget();
  CHECK_FALSE(relation.known());
}

TEST(ClockRelation, IsWithinAMicrosecondOnABusyMachine) {
  score(4, 40e3);
  // Of 62 delays of 40 us in the mean the shortest is 0.65 us, so that the middle of either bound's best is off by
  // 0.46 us rms; the line through 16 of them by half of that at its end.
  const Score score_40us = score(20, 40e3);
  CHECK_TEXT(score_40us.rms_ns() < 1000.0, std::to_string(score_40us.rms_ns()).c_str());
}

TEST(ClockRelation, StatesHowUncertainItIs) {
  Score all;
  for (int run = 0; run < 40; ++run) {
    relation.forget();
    clock.drift = std::uniform_real_distribution<double>(-100e-6, 100e-6)(random);
    clock.stamps_late = Duration{std::uniform_int_distribution<std::int64_t>(-500, 500)(random)};
    score(5, 30e3);
    all.add(error_ns(now), sd_ns(now));
  }
  // The root of a mean of 40 squares is within a third of 1 (3 / sqrt(80)), had the errors a normal distribution of
  // that deviation; what all observations share is counted twice at worst, which makes it smaller.
  const std::string text = std::to_string(all.normalized());
  CHECK_TEXT(all.normalized() > 0.4 && all.normalized() < 1.35, text.c_str());
}

// A request is on its way within microseconds of the call that writes it; a reply is heard once a thread has been woken
// for it, or the other way round. Nothing but how the ways' delays scatter tells which is the longer one.
TEST(ClockRelation, IsWithinAMicrosecondWhereOneWayIsLonger) {
  const auto share = [&] { return std::uniform_real_distribution<double>()(random); };
  const std::vector<std::pair<const char*, std::function<double()>>> ways{
      {"5 to 70 us, all alike", [&] { return 5e3 + 65e3 * share(); }},
      {"10 to 70 us, half below 18", [&] { return 10e3 + 60e3 * std::pow(share(), 3); }},
      {"5 us and 15 us more in the mean", [&] { return 5e3 + exponential_ns(15e3); }}};
  for (const bool reply_is_longer : {true, false}) {
    for (const auto& [name, longer_ns] : ways) {
      Score score;
      for (int run = 0; run < 20; ++run) {
        relation.forget();
        clock.drift = std::uniform_real_distribution<double>(-60e-6, 60e-6)(random);
        for (int beats = 0; beats < 2500; ++beats, now += kBeat) {
          const Duration first{std::llround(exponential_ns(1e3))}, second{std::llround(longer_ns())};
          const MonoTime received = now + (reply_is_longer ? first : second);
          relation.observe(now, clock.ticks(received), received + (reply_is_longer ? second : first));
          if (beats > 1000 && beats % 50 == 0) score.add(error_ns(now), sd_ns(now));
        }
      }
      std::printf("%s takes %s: %.3f us rms, %.2f of what it states\n", reply_is_longer ? "reply" : "request", name,
                  1e-3 * score.rms_ns(), score.normalized());
      CHECK_TEXT(score.rms_ns() < 1000.0, name);
      CHECK_TEXT(score.normalized() < 1.35, name);
    }
  }
}

TEST(ClockRelation, StatesWhatItCannotKnowOfTheWays) {
  // The answer always takes 60 us longer than the request: 30 us are in the offset, and nobody can tell.
  for (int beats = 0; beats < 1500; ++beats) {
    const MonoTime received = now + Duration{std::llround(exponential_ns(5e3))};
    relation.observe(now, clock.ticks(received), received + microseconds(60) + Duration{std::llround(exponential_ns(5e3))});
    now += kBeat;
  }
  DOUBLES_EQUAL(30e3, error_ns(now), 1e3);
  CHECK(sd_ns(now) > 15e3 && sd_ns(now) < 20e3);  // 60 us / sqrt(12)
}

TEST(ClockRelation, FindsTheDrift) {
  for (const double drift : {-100e-6, 0.0, 100e-6}) {
    relation.forget();
    clock.drift = drift;
    score(5, 20e3);
    // The bounds' middles are off by 0.2 us, their times spread by 1.2 s, and there are 16 of them: 0.05e-6; four times that.
    DOUBLES_EQUAL(drift, relation.drift(), 0.2e-6);
  }
}

TEST(ClockRelation, IsGoodForAShotAhead) {
  score(5, 20e3);
  // A drift that is off by 0.05e-6 makes 0.1 us in two seconds.
  CHECK(std::abs(error_ns(now + milliseconds(2000))) < 2e3);
  CHECK(sd_ns(now + milliseconds(2000)) < 2e3);
}

TEST(ClockRelation, DoesNotMindAMachineThatStandsStill) {
  stall_every = milliseconds(100);
  stall = milliseconds(20);
  score(4, 30e3);
  const Score stalled = score(20, 30e3);
  CHECK_TEXT(stalled.rms_ns() < 1000.0, std::to_string(stalled.rms_ns()).c_str());
}

TEST(ClockRelation, KnowsHowLittleTheFirstAnswerTells) {
  beat(0.1e3, microseconds(100));
  CHECK(std::abs(error_ns(now)) < 3.0 * sd_ns(now));
  CHECK(sd_ns(now) > 50e3);  // 200 us / sqrt(12)
  // A second later the drift of two crystals is not known: 60 us.
  CHECK(sd_ns(now + milliseconds(1000)) > 80e3);
}

TEST(ClockRelation, GoesToTicksAndBack) {
  score(3, 20e3);
  for (int i = 0; i < 1000; ++i) {
    const MonoTime at = now + Duration{std::uniform_int_distribution<std::int64_t>(-2'000'000'000, 2'000'000'000)(random)};
    const auto there_and_back = (relation.to_time(relation.to_ticks(at)) - at).count();
    CHECK(std::abs(there_and_back) <= kTick_ns / 2 + 1);  // and a nanosecond of rounding
  }
}

TEST(ClockRelation, StartsAnewWhenARateIsChanged) {
  score(5, 20e3);
  // NTP makes this machine's clock go faster by 400 ppm: as if the other one had slowed down since then.
  const Ticks then = clock.ticks(now);
  clock.drift += 400e-6;
  clock.started += Duration{(clock.ticks(now) - then) * kTick_ns};
  score(5, 20e3);
  CHECK(std::abs(error_ns(now)) < 5e3);
  DOUBLES_EQUAL(clock.drift, relation.drift(), 2e-6);
}

TEST(ClockRelation, LeavesOutWhatIsNoBracket) {
  score(2, 20e3);
  const double before = error_ns(now);
  relation.observe(now, clock.ticks(now) + 1'000'000, now - microseconds(1));
  CHECK_EQUAL(before, error_ns(now));
}
