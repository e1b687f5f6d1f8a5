#include "firmware/core/interlock.hpp"

#include <array>
#include <string>
#include <vector>
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::firmware;
using Kind = Interlock::Effect::Kind;

namespace {
constexpr std::int64_t kHost = 11, kOther = 22, kToken = 1001;
constexpr Duration kExpires = milliseconds(30'000);
constexpr MonoTime kNow{1'000'000'000};
}  // namespace

TEST_GROUP(Interlock) {
  Interlock lock{kExpires};
  void setup() override {
    lock.key(true);
    lock.estop(false);
  }
  void arm() { POINTERS_EQUAL(nullptr, lock.arm(kHost, kToken, kNow)); }
  void fire() {
    arm();
    POINTERS_EQUAL(nullptr, lock.fire(kHost, kToken, false, kNow));
  }
  void put_in(State state) {
    if (state == State::armed) arm();
    if (state == State::firing) fire();
    if (state == State::fault) lock.fault("broken");
    CHECK(lock.state() == state);
  }
};

TEST(Interlock, StartsIdleAndUnsafe) {
  Interlock fresh{kExpires};
  CHECK(fresh.state() == State::idle);
  STRCMP_EQUAL("the e-stop is pressed", fresh.arm(kHost, kToken, kNow));
}

TEST(Interlock, ArmsOnlyWithTheKeyOnAndTheEStopReleased) {
  lock.key(false);
  STRCMP_EQUAL("the key is off", lock.arm(kHost, kToken, kNow));
  lock.key(true);
  lock.estop(true);
  STRCMP_EQUAL("the e-stop is pressed", lock.arm(kHost, kToken, kNow));
  lock.estop(false);
  arm();
  CHECK(lock.arm_host() == kHost);
  CHECK(lock.arm_token() == kToken);
  CHECK(lock.arm_expires() == kNow + kExpires);
}

TEST(Interlock, FiresOnceForAToken) {
  fire();
  CHECK_EQUAL(0, lock.arm_token());
  lock.shot_over();
  STRCMP_EQUAL("not armed", lock.fire(kHost, kToken, false, kNow));
}

TEST(Interlock, RefusesAnotherTokenOrAnotherHostAndStaysArmed) {
  arm();
  const char* refusal = "not the token that was given to this host";
  STRCMP_EQUAL(refusal, lock.fire(kHost, kToken + 1, false, kNow));
  STRCMP_EQUAL(refusal, lock.fire(kOther, kToken, false, kNow));
  STRCMP_EQUAL(refusal, lock.fire(kHost, 0, false, kNow));
  CHECK(lock.state() == State::armed);
}

TEST(Interlock, LetsNoOtherHostTakeOverAnArming) {
  arm();
  STRCMP_EQUAL("another host has armed", lock.arm(kOther, kToken + 5, kNow));
  CHECK(lock.arm_host() == kHost);
}

TEST(Interlock, ForgetsTheOldTokenWhenTheHostArmsAnew) {
  arm();
  POINTERS_EQUAL(nullptr, lock.arm(kHost, kToken + 1, kNow));
  CHECK(lock.fire(kHost, kToken, false, kNow) != nullptr);
  POINTERS_EQUAL(nullptr, lock.fire(kHost, kToken + 1, false, kNow));
}

TEST(Interlock, LetsTheArmingExpire) {
  arm();
  CHECK(lock.tick(kNow + kExpires - nanoseconds(1)).kind == Kind::none);
  CHECK(lock.tick(kNow + kExpires).kind == Kind::disarmed);
  CHECK(lock.state() == State::idle);
}

TEST(Interlock, RefusesAFireAfterTheExpiryEvenBeforeItWasNoticed) {
  arm();
  STRCMP_EQUAL("the arming has expired", lock.fire(kHost, kToken, false, kNow + kExpires));
}

TEST(Interlock, ReleasesTheTriggerOnceAShot) {
  fire();
  CHECK(lock.release_trigger());
  CHECK_FALSE(lock.release_trigger());
}

TEST(Interlock, ReleasesNoTriggerInADryShot) {
  arm();
  POINTERS_EQUAL(nullptr, lock.fire(kHost, kToken, true, kNow));
  CHECK_FALSE(lock.release_trigger());
}

TEST(Interlock, ReleasesNoTriggerAfterAnAbort) {
  fire();
  lock.aborted();
  CHECK_FALSE(lock.release_trigger());
}

TEST(Interlock, LatchesTheFirstFaultUntilItIsCleared) {
  lock.fault("first");
  lock.fault("second");
  STRCMP_EQUAL("first", lock.fault_words());
  STRCMP_EQUAL("first", lock.arm(kHost, kToken, kNow));
  POINTERS_EQUAL(nullptr, lock.clear());
  arm();
}

TEST(Interlock, GoesToFaultOnlyOnceAnAbortedShotIsOver) {
  fire();
  CHECK(lock.fault("broken").kind == Kind::abort);
  CHECK(lock.state() == State::firing);
  lock.shot_over();
  CHECK(lock.state() == State::fault);
}

TEST(Interlock, HasTheTransitionsOfItsTable) {
  struct Row {
    const char* input;
    State from, to;
    bool refused;
    Kind effect;
  };
  const Row rows[] = {
      {"arm", State::idle, State::armed, false, Kind::none},
      {"arm", State::armed, State::armed, false, Kind::none},
      {"arm", State::firing, State::firing, true, Kind::none},
      {"arm", State::fault, State::fault, true, Kind::none},
      {"fire", State::idle, State::idle, true, Kind::none},
      {"fire", State::armed, State::firing, false, Kind::none},
      {"fire", State::firing, State::firing, true, Kind::none},
      {"fire", State::fault, State::fault, true, Kind::none},
      {"disarm", State::idle, State::idle, false, Kind::none},
      {"disarm", State::armed, State::idle, false, Kind::disarmed},
      {"disarm", State::firing, State::firing, false, Kind::abort},
      {"disarm", State::fault, State::fault, false, Kind::none},
      {"key", State::idle, State::idle, false, Kind::none},
      {"key", State::armed, State::idle, false, Kind::disarmed},
      {"key", State::firing, State::firing, false, Kind::abort},
      {"key", State::fault, State::fault, false, Kind::none},
      {"estop", State::idle, State::idle, false, Kind::none},
      {"estop", State::armed, State::idle, false, Kind::disarmed},
      {"estop", State::firing, State::firing, false, Kind::abort},
      {"estop", State::fault, State::fault, false, Kind::none},
      {"fault", State::idle, State::fault, false, Kind::none},
      {"fault", State::armed, State::fault, false, Kind::disarmed},
      {"fault", State::firing, State::firing, false, Kind::abort},
      {"over", State::idle, State::idle, false, Kind::none},
      {"over", State::armed, State::armed, false, Kind::none},
      {"over", State::firing, State::idle, false, Kind::none},
      {"over", State::fault, State::fault, false, Kind::none},
      {"clear", State::idle, State::idle, true, Kind::none},
      {"clear", State::armed, State::armed, true, Kind::none},
      {"clear", State::firing, State::firing, true, Kind::none},
      {"clear", State::fault, State::idle, false, Kind::none},
  };
  for (const Row& row : rows) {
    lock = Interlock{kExpires};
    setup();
    put_in(row.from);
    const std::string input = row.input;
    const char* refusal = nullptr;
    Interlock::Effect effect;
    if (input == "arm") refusal = lock.arm(kHost, kToken + 1, kNow);
    if (input == "fire") refusal = lock.fire(kHost, kToken, false, kNow);
    if (input == "clear") refusal = lock.clear();
    if (input == "disarm") effect = lock.disarm();
    if (input == "key") effect = lock.key(false);
    if (input == "estop") effect = lock.estop(true);
    if (input == "fault") effect = lock.fault("broken");
    if (input == "over") lock.shot_over();
    const std::string place = input + " in state " + std::to_string(static_cast<int>(row.from));
    CHECK_EQUAL_TEXT(static_cast<int>(row.to), static_cast<int>(lock.state()), place.c_str());
    CHECK_EQUAL_TEXT(row.refused, refusal != nullptr, place.c_str());
    CHECK_EQUAL_TEXT(static_cast<int>(row.effect), static_cast<int>(effect.kind), place.c_str());
  }
}

namespace {

// Every sequence of inputs up to a depth. The rule is judged from the history alone, without a state machine.
enum class In {
  arm,
  arm_other,
  fire,
  fire_old,
  fire_other,
  fire_dry,
  disarm,
  key_off,
  key_on,
  stop,
  release,
  expire,
  fault,
  clear,
  over,
  abort,
  trigger,
  count
};

struct Walk {
  Interlock lock{kExpires};
  MonoTime now = kNow;
  std::int64_t next_token = 1;
  std::int64_t token = 0;   // that the host got last
  std::int64_t before = 0;  // the one before
};

void apply(Walk& walk, In input) {
  switch (input) {
    case In::arm:
      if (walk.lock.arm(kHost, walk.next_token, walk.now) == nullptr) {
        walk.before = walk.token;
        walk.token = walk.next_token;
      }
      ++walk.next_token;
      break;
    case In::arm_other:
      walk.lock.arm(kOther, walk.next_token++, walk.now);
      break;
    case In::fire:
      walk.lock.fire(kHost, walk.token, false, walk.now);
      break;
    case In::fire_old:
      walk.lock.fire(kHost, walk.before, false, walk.now);
      break;
    case In::fire_other:
      walk.lock.fire(kOther, walk.token, false, walk.now);
      break;
    case In::fire_dry:
      walk.lock.fire(kHost, walk.token, true, walk.now);
      break;
    case In::disarm:
      walk.lock.disarm();
      break;
    case In::key_off:
      walk.lock.key(false);
      break;
    case In::key_on:
      walk.lock.key(true);
      break;
    case In::stop:
      walk.lock.estop(true);
      break;
    case In::release:
      walk.lock.estop(false);
      break;
    case In::expire:
      walk.now = walk.now + kExpires;
      walk.lock.tick(walk.now);
      break;
    case In::fault:
      walk.lock.fault("broken");
      break;
    case In::clear:
      walk.lock.clear();
      break;
    case In::over:
      walk.lock.shot_over();
      break;
    case In::abort:
      walk.lock.aborted();
      break;
    case In::trigger:
    case In::count:
      break;
  }
}

bool takes_permission(In input) {
  return input == In::disarm || input == In::key_off || input == In::stop || input == In::fault;
}
bool spends_token(In input) { return input == In::expire || input == In::fire || input == In::fire_dry; }
bool ends_shot(In input) { return input == In::abort || input == In::over || input == In::trigger; }

/// There must be an ARM and later a FIRE of the same host such that nothing between them spent the token or
/// took the permission, and nothing since took it or ended the shot.
bool history_allows_trigger(const std::vector<In>& history) {
  for (auto fire = history.rbegin(); fire != history.rend(); ++fire) {
    if (takes_permission(*fire) || ends_shot(*fire)) return false;
    if (*fire != In::fire) continue;
    for (auto arm = fire + 1; arm != history.rend(); ++arm) {
      if (*arm == In::arm) return true;
      if (takes_permission(*arm) || spends_token(*arm)) break;
    }
  }
  return false;
}

std::int64_t walked = 0;
std::int64_t triggered = 0;

void explore(const Walk& walk, std::vector<In>& history, int depth) {
  ++walked;
  Walk trial = walk;
  if (trial.lock.release_trigger()) {
    ++triggered;
    CHECK_TRUE(history_allows_trigger(history));
    CHECK_TRUE(trial.lock.key_active());
    CHECK_FALSE(trial.lock.estop_active());
  }
  if (depth == 0) return;
  for (int i = 0; i < static_cast<int>(In::count); ++i) {
    const In input = static_cast<In>(i);
    Walk next = walk;
    if (input == In::trigger) {
      if (!next.lock.release_trigger()) continue;
    } else {
      apply(next, input);
    }
    history.push_back(input);
    explore(next, history, depth - 1);
    history.pop_back();
  }
}

}  // namespace

TEST(Interlock, NeverReleasesTheTriggerUnarmedSpentStoppedOrWithAnotherToken) {
  constexpr int kDepth = 5;
  Walk walk;
  walk.lock = lock;
  std::vector<In> history;
  walked = triggered = 0;
  explore(walk, history, kDepth);
  CHECK(walked > 500'000);
  CHECK(triggered > 100);  // the rule is not kept by never firing at all
}
