#include "firmware/core/interlock.hpp"

#include <array>
#include <string>

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;
using Kind = Interlock::Effect::Kind;

namespace {
constexpr std::int64_t kHost = 11, kOther = 22, kToken = 1001;
constexpr Duration kExpires = milliseconds(30'000);
constexpr MonoTime kNow = from_ns(1'000'000'000);
constexpr std::int32_t kShot = 1;
}  // namespace

TEST_GROUP(Interlock) {
  Interlock lock{kExpires};
  void setup() override { lock.start(true, false); }
  /// After the stops at kNow: a person acts, and the delay passes.
  void reset(std::int64_t host = kHost) {
    POINTERS_EQUAL(nullptr, lock.reset(host, kNow + nanoseconds(1), kNow - Interlock::kRestartDelay));
  }
  void arm() { POINTERS_EQUAL(nullptr, lock.arm(kHost, kToken, kNow)); }
  void fire() {
    arm();
    POINTERS_EQUAL(nullptr, lock.fire(kHost, kToken, kShot, false, kNow));
  }
  void put_in(State state) {
    if (state == State::armed) arm();
    if (state == State::firing) fire();
    if (state == State::fault) lock.fault("broken");
    if (state == State::stopped) lock.disarm(kNow);
    if (state == State::spent) {
      fire();
      lock.shot_over();
    }
    CHECK_EQUAL(state, lock.state());
  }
};

TEST(Interlock, StartsStoppedAndUnsafe) {
  Interlock fresh{kExpires};
  CHECK_EQUAL(State::stopped, fresh.state());
  STRCMP_EQUAL("the e-stop is pressed", fresh.arm(kHost, kToken, kNow));
}

TEST(Interlock, ArmsOnlyWithTheKeyOnAndTheEStopReleased) {
  lock.key(false, kNow);
  STRCMP_EQUAL("the key is off", lock.arm(kHost, kToken, kNow));
  lock.key(true, kNow);
  lock.estop(true, kNow);
  STRCMP_EQUAL("the e-stop is pressed", lock.arm(kHost, kToken, kNow));
  lock.estop(false, kNow);
  reset();
  arm();
  CHECK_EQUAL(kHost, lock.arm_host());
  CHECK_EQUAL(kToken, lock.arm_token());
  CHECK_EQUAL(kNow + kExpires, lock.arm_expires());
}

TEST(Interlock, ArmsNothingAfterAStopThatNobodyHasReset) {
  const auto refused = [this] {
    STRCMP_EQUAL("stopped: a person must give the command to fire anew", lock.arm(kHost, kToken, kNow));
    CHECK_EQUAL(State::stopped, lock.state());
  };
  lock.key(false, kNow);
  lock.key(true, kNow);
  refused();
  reset();
  lock.estop(true, kNow);
  lock.estop(false, kNow);
  refused();
  reset();
  lock.disarm(kNow);
  refused();
  reset();
  lock.suspended(kNow);
  refused();
}

TEST(Interlock, ResetsNothingThatCameAfterThePersonActed) {
  const char* refusal = "the rig was stopped, or key or e-stop moved, after this command was given: give it again";
  lock.estop(true, kNow);
  lock.estop(false, kNow + milliseconds(5));
  STRCMP_EQUAL(refusal, lock.reset(kHost, kNow + milliseconds(5), kNow + milliseconds(6)));
  POINTERS_EQUAL(nullptr, lock.reset(kHost, kNow + milliseconds(5) + nanoseconds(1), kNow + milliseconds(6)));
}

TEST(Interlock, ResetsNothingWhileASwitchIsInTheWay) {
  const MonoTime later = kNow + milliseconds(1);
  lock.estop(true, kNow);
  STRCMP_EQUAL("the e-stop is pressed", lock.reset(kHost, later, later));
  lock.estop(false, kNow);
  lock.key(false, kNow);
  STRCMP_EQUAL("the key is off", lock.reset(kHost, later, later));
}

TEST(Interlock, ArmsNoSoonerThanTheRestartDelayAfterAReset) {
  const MonoTime later = kNow + milliseconds(1), due = later + Interlock::kRestartDelay;
  lock.disarm(kNow);
  POINTERS_EQUAL(nullptr, lock.reset(kHost, later, later));
  STRCMP_EQUAL("a stop was reset just now", lock.arm(kHost, kToken, due - nanoseconds(1)));
  POINTERS_EQUAL(nullptr, lock.arm(kHost, kToken, due));
}

TEST(Interlock, ArmsForNoHostWhosePersonHasNotActedSinceTheStop) {
  lock.disarm(kNow);
  reset(kOther);
  STRCMP_EQUAL("stopped: a person must give the command to fire anew at this host", lock.arm(kHost, kToken, kNow));
  reset(kHost);
  arm();
}

TEST(Interlock, ForgetsTheHostThatActedLongestAgo) {
  lock.disarm(kNow);
  for (std::int64_t host = 1; host <= 17; ++host) reset(host);
  CHECK_FALSE(lock.admitted(1));
  CHECK(lock.admitted(2));
  CHECK(lock.admitted(17));
}

TEST(Interlock, ShowsAStopEvenWhereAFaultIsLatchedToo) {
  lock.fault("broken");
  lock.disarm(kNow);
  CHECK_EQUAL(State::stopped, lock.state());
  reset();
  CHECK_EQUAL(State::fault, lock.state());
}

TEST(Interlock, DropsWhatIsArmedWhenTheLoopStoodStillAndNeedsNoReset) {
  arm();
  CHECK_EQUAL(Kind::disarmed, lock.stood_still().kind);
  arm();
}

TEST(Interlock, StartsStoppedWithTheKeyOffOrTheEStopPressed) {
  for (const auto& [key, estop] : {std::pair{false, false}, std::pair{true, true}}) {
    Interlock fresh{kExpires};
    fresh.start(key, estop);
    CHECK_EQUAL(State::stopped, fresh.state());
    fresh.key(true, kNow);
    fresh.estop(false, kNow);
    STRCMP_EQUAL("stopped: a person must give the command to fire anew", fresh.arm(kHost, kToken, kNow));
  }
}

TEST(Interlock, FiresOnceForAToken) {
  fire();
  CHECK_EQUAL(0, lock.arm_token());
  CHECK_EQUAL(0, lock.arm_host());
  CHECK(lock.arm_expires() == MonoTime{});
  lock.shot_over();
  CHECK_EQUAL(State::spent, lock.state());
  STRCMP_EQUAL("the arming is spent: arm again", lock.fire(kHost, kToken, kShot + 1, false, kNow));
}

TEST(Interlock, ArmsForAnotherShotAfterASpentOne) {
  fire();
  lock.aborted();
  lock.shot_over();
  CHECK_EQUAL(State::spent, lock.state());
  arm();
  STRCMP_EQUAL("a shot of this number is spent", lock.fire(kHost, kToken, kShot, false, kNow));
  POINTERS_EQUAL(nullptr, lock.fire(kHost, kToken, kShot + 1, false, kNow));
}

TEST(Interlock, KnowsTheNumbersThatEarlierStartsUsed) {
  lock = Interlock{kExpires, 41};
  setup();
  arm();
  STRCMP_EQUAL("a shot of this number is spent", lock.fire(kHost, kToken, 41, false, kNow));
  POINTERS_EQUAL(nullptr, lock.fire(kHost, kToken, 42, false, kNow));
  CHECK_EQUAL(42, lock.shot_id());
}

TEST(Interlock, ReleasesTheTriggerForNoOtherShotThanTheOneThatIsFired) {
  fire();
  CHECK_FALSE(lock.release_trigger(kShot - 1));
  CHECK_FALSE(lock.release_trigger(kShot + 1));
  CHECK(lock.release_trigger(kShot));
}

TEST(Interlock, RefusesAnotherTokenOrAnotherHostAndStaysArmed) {
  arm();
  const char* refusal = "the token is not that of the arming";
  STRCMP_EQUAL(refusal, lock.fire(kHost, kToken + 1, kShot, false, kNow));
  STRCMP_EQUAL(refusal, lock.fire(kOther, kToken, kShot, false, kNow));
  STRCMP_EQUAL(refusal, lock.fire(kHost, 0, kShot, false, kNow));
  CHECK_EQUAL(State::armed, lock.state());
}

TEST(Interlock, LetsNoOtherHostTakeOverAnArming) {
  arm();
  STRCMP_EQUAL("another host has armed the rig", lock.arm(kOther, kToken + 5, kNow));
  CHECK_EQUAL(kHost, lock.arm_host());
}

TEST(Interlock, ForgetsTheOldTokenWhenTheHostArmsAnew) {
  arm();
  POINTERS_EQUAL(nullptr, lock.arm(kHost, kToken + 1, kNow));
  CHECK(lock.fire(kHost, kToken, kShot, false, kNow) != nullptr);
  POINTERS_EQUAL(nullptr, lock.fire(kHost, kToken + 1, kShot, false, kNow));
}

TEST(Interlock, LetsTheArmingExpire) {
  arm();
  CHECK_EQUAL(Kind::none, lock.tick(kNow + kExpires - nanoseconds(1)).kind);
  CHECK_EQUAL(Kind::disarmed, lock.tick(kNow + kExpires).kind);
  CHECK_EQUAL(State::idle, lock.state());
}

TEST(Interlock, RefusesAFireAfterTheExpiryEvenBeforeItWasNoticed) {
  arm();
  STRCMP_EQUAL("the arming has expired", lock.fire(kHost, kToken, kShot, false, kNow + kExpires));
}

TEST(Interlock, ReleasesTheTriggerOnceAShot) {
  fire();
  CHECK(lock.release_trigger(kShot));
  CHECK_FALSE(lock.release_trigger(kShot));
}

TEST(Interlock, ReleasesNoTriggerInADryShot) {
  arm();
  POINTERS_EQUAL(nullptr, lock.fire(kHost, kToken, kShot, true, kNow));
  CHECK_FALSE(lock.release_trigger(kShot));
}

TEST(Interlock, ReleasesNoTriggerAfterAnAbort) {
  fire();
  lock.aborted();
  CHECK_FALSE(lock.release_trigger(kShot));
}

TEST(Interlock, LatchesTheFirstFaultUntilItIsCleared) {
  lock.fault("first");
  lock.fault("second");
  STRCMP_EQUAL("first", lock.fault_text());
  STRCMP_EQUAL("first", lock.arm(kHost, kToken, kNow));
  POINTERS_EQUAL(nullptr, lock.clear());
  arm();
}

TEST(Interlock, GoesToFaultOnlyOnceAnAbortedShotIsOver) {
  fire();
  CHECK_EQUAL(Kind::abort, lock.fault("broken").kind);
  CHECK_EQUAL(State::firing, lock.state());
  lock.shot_over();
  CHECK_EQUAL(State::fault, lock.state());
}

namespace {

constexpr std::array kInputNames{"arm",    "fire",      "disarm",     "expiry",  "key off",
                                 "key on", "e-stop on", "e-stop off", "sleep",   "fault",
                                 "clear",  "reset",     "trigger",    "aborted", "shot over"};
static_assert(kInputNames.size() == kInterlockEventCount);

struct Outcome {
  TransitionKind kind = TransitionKind::none;
  State state = State::idle;
};

TransitionKind kind_of(const char* refusal) {
  return refusal == nullptr ? TransitionKind::grant : TransitionKind::refuse;
}
TransitionKind kind_of(Interlock::Effect effect) {
  return effect.kind == Kind::abort      ? TransitionKind::abort
         : effect.kind == Kind::disarmed ? TransitionKind::disarm
                                         : TransitionKind::none;
}

/// The input, with all that a grant needs.
Outcome given(Interlock lock, InterlockEvent input) {
  TransitionKind kind = TransitionKind::none;
  switch (input) {
    case InterlockEvent::arm:
      kind = kind_of(lock.arm(kHost, kToken + 1, kNow));
      break;
    case InterlockEvent::fire:
      kind = kind_of(lock.fire(kHost, kToken, kShot + 1, false, kNow));
      break;
    case InterlockEvent::disarm:
      kind = kind_of(lock.disarm(kNow));
      break;
    case InterlockEvent::expiry:
      kind = kind_of(lock.tick(kNow + kExpires));
      break;
    case InterlockEvent::key_off:
    case InterlockEvent::key_on:
      kind = kind_of(lock.key(input == InterlockEvent::key_on, kNow));
      break;
    case InterlockEvent::estop_on:
    case InterlockEvent::estop_off:
      kind = kind_of(lock.estop(input == InterlockEvent::estop_on, kNow));
      break;
    case InterlockEvent::suspended:
      kind = kind_of(lock.suspended(kNow));
      break;
    case InterlockEvent::reset:
      kind = kind_of(lock.reset(kHost, kNow + nanoseconds(1), kNow));
      break;
    case InterlockEvent::fault:
      kind = kind_of(lock.fault("broken"));
      break;
    case InterlockEvent::clear:
      kind = kind_of(lock.clear());
      break;
    case InterlockEvent::trigger:
      kind = lock.release_trigger(kShot) ? TransitionKind::grant : TransitionKind::refuse;
      break;
    case InterlockEvent::aborted:
      lock.aborted();
      break;
    case InterlockEvent::shot_over:
      lock.shot_over();
      break;
  }
  return {kind, lock.state()};
}

}  // namespace

TEST(Interlock, HandlesEveryEventInEveryStateAsItsTableSays) {
  for (std::size_t state = 0; state < kStateCount; ++state) {
    for (std::size_t input = 0; input < kInterlockEventCount; ++input) {
      lock = Interlock{kExpires};
      setup();
      put_in(static_cast<State>(state));
      // A fault that is latched beside the stop is what CLEAR is for.
      if (static_cast<State>(state) == State::stopped &&
          static_cast<InterlockEvent>(input) == InterlockEvent::clear)
        lock.fault("broken");
      const Outcome seen = given(lock, static_cast<InterlockEvent>(input));
      const Transition& cell = kTransitionTable[input].in[state];
      const std::string place = std::string(kInputNames[input]) + " in state " + std::to_string(state);
      CHECK_EQUAL_TEXT(static_cast<int>(cell.kind), static_cast<int>(seen.kind), place.c_str());
      CHECK_EQUAL_TEXT(static_cast<int>(cell.next), static_cast<int>(seen.state), place.c_str());
    }
  }
}
