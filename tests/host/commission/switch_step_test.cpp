// Key and e-stop as a person moves them, on rigs whose wires are right and wrong.
#include "host/commission/steps.hpp"

#include <functional>
#include <map>
#include <string>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

/// Key and e-stop as they are wired to the firmware's two lines, and a person who does as told after two seconds.
class Panel {
 public:
  bool swapped = false, key_inverted = false, estop_inverted = false, key_pull = true, estop_pull = true;
  bool key_dead = false;
  int bounces = 0;
  std::set<Act> ignores;  ///< what the person does not do

  Panel() : rig_(*host::read_rig("rig = \"bench\"\n", "rig.toml")) {}

  StepResult run(std::unique_ptr<Step> asked, Duration patience = std::chrono::seconds{10}) {
    Step& step = *asked;
    step.begin(situation(patience));
    for (int turn = 0; turn < 10'000; ++turn) {
      now_ += milliseconds{50};
      if (due_ && now_ >= *due_) act(step);
      Request request = step.step(situation(patience));
      if (auto* done = std::get_if<Done>(&request)) return done->results.front();
      const Act wanted = std::get<Wait>(request).act;
      if (wanted != wanted_) due_ = now_ + std::chrono::seconds{2};
      wanted_ = wanted;
    }
    return failed("endless", "", "");
  }

  bool key_on = false, estop_released = false, key_wire = true, estop_wire = true;

 private:
  /// As the firmware reads its lines.
  std::pair<bool, bool> levels() const {
    const bool key = key_dead ? false : key_wire ? key_on != key_inverted : key_pull ? false : held_key_;
    const bool estop = estop_wire ? estop_released == estop_inverted : estop_pull ? true : held_estop_;
    return swapped ? std::pair{estop, key} : std::pair{key, estop};
  }
  Situation situation(Duration patience) {
    status_t status{};
    status.mono_ns = now_.time_since_epoch().count();
    std::tie(status.key_active, status.estop_active) = levels();
    return {now_, status, rig_, "", true, 0, false, true, patience};
  }
  void act(Step& step) {
    due_.reset();
    if (ignores.contains(wanted_)) return;
    const auto before = levels();
    std::tie(held_key_, held_estop_) = before;
    switch (wanted_) {
      case Act::key_off:
        key_on = false;
        break;
      case Act::key_on:
        key_on = true;
        break;
      case Act::key_wire_off:
        key_wire = false;
        break;
      case Act::key_wire_on:
        key_wire = true;
        break;
      case Act::estop_press:
        estop_released = false;
        break;
      case Act::estop_release:
        estop_released = true;
        break;
      case Act::estop_wire_off:
        estop_wire = false;
        break;
      case Act::estop_wire_on:
        estop_wire = true;
        break;
      case Act::none:
        break;
    }
    const auto after = levels();
    for (int edge = 0; edge <= 2 * bounces; ++edge) {
      const bool there = edge % 2 == 0;
      if (before.first != after.first) send(step, event_t::KEY, there ? after.first : before.first);
      if (before.second != after.second) send(step, event_t::ESTOP, there ? after.second : before.second);
    }
  }
  void send(Step& step, std::int8_t kind, bool level) {
    event_t event{};
    event.kind = kind;
    event.level = level ? 1 : 0;
    event.device_time_ns = now_.time_since_epoch().count() + ++edges_;
    step.on_event(event, now_);
  }

  host::RigFile rig_;
  HostTime now_{std::chrono::seconds{100}};
  Act wanted_ = Act::none;
  std::optional<HostTime> due_;
  bool held_key_ = false, held_estop_ = false;
  std::int64_t edges_ = 0;
};

}  // namespace

TEST_GROUP(SwitchStep) {
  Panel panel;

  void expect(const StepResult& result, const char* fault) {
    CHECK_EQUAL_TEXT(std::string(fault), result.fault, result.words.c_str());
    CHECK_TRUE_TEXT(result.state == (*fault == '\0' ? StepState::passed : StepState::failed),
                    result.words.c_str());
    CHECK_EQUAL(*fault == '\0', result.advice.empty());
  }
};

TEST(SwitchStep, PassesARigThatIsWiredRight) {
  expect(panel.run(key_step()), "");
  expect(panel.run(key_wire_step()), "");
  expect(panel.run(estop_step()), "");
  const StepResult last = panel.run(estop_wire_step());
  expect(last, "");
  DOUBLES_EQUAL(2.0, *last.value, 0.0);
  CHECK_TRUE(panel.key_on);
  CHECK_TRUE(panel.estop_released);
}

TEST(SwitchStep, ForgivesContactsThatBounce) {
  panel.bounces = 3;
  expect(panel.run(key_step()), "");
  expect(panel.run(estop_step()), "");
}

TEST(SwitchStep, FindsAnInvertedLineWhereverTheSwitchBegins) {
  for (const bool begins : {false, true}) {
    panel = Panel();
    panel.key_inverted = panel.estop_inverted = true;
    panel.key_on = panel.estop_released = begins;
    const StepResult key = panel.run(key_step());
    CHECK_TRUE(key.state == StepState::failed);
    const StepResult estop = panel.run(estop_step());
    CHECK_TRUE(estop.state == StepState::failed);
  }
}

TEST(SwitchStep, NamesAnInvertedLineWhereTheSwitchBeginsAsAsked) {
  panel.key_inverted = panel.estop_inverted = true;
  expect(panel.run(key_step()), "inverted");
  expect(panel.run(estop_step()), "inverted");
}

TEST(SwitchStep, NamesSwappedLines) {
  panel.swapped = true;
  expect(panel.run(key_step()), "lines_swapped");
  panel = Panel();
  panel.swapped = true;
  panel.key_on = true;
  panel.estop_released = false;
  expect(panel.run(estop_step()), "lines_swapped");
}

TEST(SwitchStep, NamesALineWithoutItsPull) {
  panel.key_pull = panel.estop_pull = false;
  expect(panel.run(key_step()), "");
  expect(panel.run(key_wire_step()), "missing_pull");
  panel.key_wire = true;
  expect(panel.run(estop_step()), "");
  expect(panel.run(estop_wire_step()), "missing_pull");
}

TEST(SwitchStep, NamesALineThatDoesNotMove) {
  panel.key_dead = true;
  expect(panel.run(key_step()), "stuck");
}

TEST(SwitchStep, WaitsAsLongAsThePersonIsGiven) {
  expect(panel.run(key_step(), std::chrono::seconds{3}), "");
  panel = Panel();
  expect(panel.run(key_step(), std::chrono::seconds{1}), "stuck");
}
