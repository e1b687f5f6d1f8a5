#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "host/commission/steps.hpp"

namespace strobe::commission {
namespace {

using strobe_msgs::event_t;

/// Contacts bounce: a level counts once it has lasted so long.
constexpr Duration kSettled = milliseconds{300};
/// The other line alone has moved for so long: it is the one that was moved.
constexpr Duration kOtherAlone = milliseconds{1500};

/// One thing to do, and how the line must read then.
struct SwitchAct {
  Act act = Act::none;
  std::string words;    ///< "turn the key on"
  bool level = false;   ///< the line must read: key on, e-stop pressed
  bool change = false;  ///< it must be seen to change; false: it may read so already
};

enum class Input { key, estop };

class SwitchStep final : public Step {
 public:
  SwitchStep(Input input, StepInfo info, std::string briefing, std::vector<SwitchAct> acts);

  std::string briefing(const host::RigFile&) const override { return briefing_; }
  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;
  void on_event(const strobe_msgs::event_t& event, HostTime now) override;

 private:
  struct Line {
    std::optional<bool> level;
    std::int64_t stamp_ns = 0;   ///< of the firmware's clock
    std::int64_t before_ns = 0;  ///< the same when the act began
    HostTime since;
    int changes = 0;  ///< events in this act
  };

  void read_levels(const Situation& situation);
  void enter(std::size_t act, HostTime now);
  bool reads(bool level, HostTime now) const;
  std::string other_name() const { return input_ == Input::key ? "e-stop" : "key"; }
  std::string own_name() const { return input_ == Input::key ? "key" : "e-stop"; }
  std::string word_of(bool level) const;
  StepResult swapped() const;
  StepResult inverted() const;
  StepResult unmoved(const Situation& situation) const;
  StepResult followed() const;

  Input input_;
  std::string briefing_;
  std::vector<SwitchAct> acts_;
  bool wire_ = false;
  std::size_t act_ = 0;
  bool probing_ = false;  ///< the first state was not reached: does the line move at all, and which way?
  HostTime entered_;
  Line own_, other_;
  int bounces_ = 0;
};

SwitchStep::SwitchStep(Input input, StepInfo info, std::string briefing, std::vector<SwitchAct> acts)
    : Step({std::move(info)}, {.operator_acts = true}),
      input_(input),
      briefing_(std::move(briefing)),
      acts_(std::move(acts)),
      wire_(acts_.back().act == Act::key_wire_on || acts_.back().act == Act::estop_wire_on) {}

void SwitchStep::begin(const Situation& situation) {
  own_ = other_ = {};
  bounces_ = 0;
  probing_ = false;
  read_levels(situation);
  enter(0, situation.now);
}

void SwitchStep::enter(std::size_t act, HostTime now) {
  act_ = act;
  entered_ = now;
  for (Line* line : {&own_, &other_}) {
    line->changes = 0;
    line->before_ns = line->stamp_ns;
  }
}

void SwitchStep::read_levels(const Situation& situation) {
  if (!situation.status) return;
  const auto take = [&](Line& line, bool level) {
    if (situation.status->mono_ns <= line.stamp_ns || line.level == level) return;
    line.level = level;
    line.stamp_ns = situation.status->mono_ns;
    line.since = situation.now;
  };
  take(own_, input_ == Input::key ? situation.status->key_active : situation.status->estop_active);
  take(other_, input_ == Input::key ? situation.status->estop_active : situation.status->key_active);
}

void SwitchStep::on_event(const event_t& event, HostTime now) {
  if (event.kind != event_t::KEY && event.kind != event_t::ESTOP) return;
  const bool own = (event.kind == event_t::KEY) == (input_ == Input::key);
  Line& line = own ? own_ : other_;
  if (event.device_time_ns <= line.before_ns) return;  // of an act before, and late
  ++line.changes;
  if (event.device_time_ns <= line.stamp_ns) return;  // a later status has told the level
  line.level = event.level == 1;
  line.stamp_ns = event.device_time_ns;
  line.since = now;
}

bool SwitchStep::reads(bool level, HostTime now) const {
  return own_.level == level && now - own_.since >= kSettled;
}

Request SwitchStep::step(const Situation& situation) {
  read_levels(situation);
  const HostTime now = situation.now;
  const SwitchAct& act = acts_[act_];
  const bool moved = own_.changes > 0 && now - own_.since >= kSettled;
  const bool other_moved = own_.changes == 0 && other_.changes > 0 && now - other_.since >= kOtherAlone;
  if (other_moved && (act.change || probing_)) return Done{{swapped()}};
  if (probing_) {
    if (moved) return Done{{inverted()}};
    if (now - entered_ > situation.patience) return Done{{unmoved(situation)}};
    return Wait{acts_[1].words, acts_[1].act};
  }
  if (act.change && moved && own_.level != act.level && now - own_.since >= kOtherAlone)
    return Done{{inverted()}};
  if (reads(act.level, now) && (!act.change || moved)) {
    bounces_ += std::max(0, own_.changes - 1);
    if (act_ + 1 == acts_.size()) return Done{{followed()}};
    enter(act_ + 1, now);
  } else if (now - entered_ > situation.patience) {
    if (act_ > 0 || own_.level == act.level || wire_) return Done{{unmoved(situation)}};
    probing_ = true;
    enter(0, now);
    return Wait{acts_[1].words, acts_[1].act};
  }
  return Wait{acts_[act_].words, acts_[act_].act};
}

std::string SwitchStep::word_of(bool level) const {
  if (input_ == Input::key) return level ? "on" : "off";
  return level ? "pressed" : "released";
}

StepResult SwitchStep::swapped() const {
  return failed("lines_swapped",
                fmt::format("told to {}, it was the {}'s line that changed", acts_[act_].words, other_name()),
                "the wires of key and e-stop are swapped, or their line numbers in [lines]");
}

StepResult SwitchStep::inverted() const {
  return failed(
      "inverted",
      fmt::format("the {}'s line reads {} where it should read {}", own_name(),
                  word_of(own_.level.value_or(false)), word_of(!own_.level.value_or(false))),
      input_ == Input::key
          ? "the key's contact must be closed to 3.3 V while the key is on; its line has no active_low"
          : "the e-stop's contact must be closed to 3.3 V while released; its line has active_low = true");
}

StepResult SwitchStep::unmoved(const Situation& situation) const {
  if (!situation.status) return failed("not_heard", "the firmware fell silent", "is strobed still running?");
  const SwitchAct& act = probing_ ? acts_[1] : acts_[act_];
  const std::string waited =
      fmt::format("the {}'s line still read {} {:.0f} s after: {}", own_name(),
                  word_of(own_.level.value_or(false)), to_seconds(situation.patience), act.words);
  if (act.act == Act::key_wire_off || act.act == Act::estop_wire_off)
    return failed("missing_pull", waited,
                  "without its wire the line must read the safe way: fit its pull-down of 10 kOhm, or leave "
                  "its bias in [lines] out");
  return failed("stuck", waited,
                "look for a broken wire or contact, and for the right line number in [lines]; a longer "
                "--wait gives more time");
}

StepResult SwitchStep::followed() const {
  const double wanted = static_cast<double>(acts_.size()) - 1.0;
  StepResult result =
      passed(wanted, {}, "changes seen", fmt::format("{:.0f}, each to the right level", wanted));
  result.words = wire_ ? fmt::format("without its wire the {} reads {}, with it {}", own_name(),
                                     word_of(acts_[1].level), word_of(acts_[2].level))
                       : fmt::format("the {}'s line follows: {}, then {}", own_name(),
                                     word_of(acts_[1].level), word_of(acts_[2].level));
  result.figures = {{"changes", wanted, {}, wanted, 0},
                    {"bounces", static_cast<double>(bounces_), {}, {}, 0}};
  return result;
}

}  // namespace

std::unique_ptr<Step> key_step() {
  return std::make_unique<SwitchStep>(
      Input::key, StepInfo{"key", "key turned on and off", {"chip", "lines"}},
      "Watches the key's line while you turn the key. Nothing moves. Begin with the key off.",
      std::vector<SwitchAct>{{Act::key_off, "have the key off", false, false},
                             {Act::key_on, "turn the key on", true, true},
                             {Act::key_off, "turn the key off", false, true}});
}

std::unique_ptr<Step> key_wire_step() {
  return std::make_unique<SwitchStep>(
      Input::key, StepInfo{"key_wire", "key's wire pulled", {"chip", "lines"}},
      "Watches the key's line while its wire is off the board: it must read as off. Nothing moves.",
      std::vector<SwitchAct>{
          {Act::key_on, "turn the key on", true, false},
          {Act::key_wire_off, "pull the wire of the key's line off the board", false, true},
          {Act::key_wire_on, "put the wire back", true, true}});
}

std::unique_ptr<Step> estop_step() {
  return std::make_unique<SwitchStep>(
      Input::estop, StepInfo{"estop", "e-stop released and pressed", {"chip", "lines"}},
      "Watches the e-stop's line while you use the e-stop. Nothing moves. Begin with the e-stop pressed.",
      std::vector<SwitchAct>{{Act::estop_press, "have the e-stop pressed", true, false},
                             {Act::estop_release, "release the e-stop", false, true},
                             {Act::estop_press, "press the e-stop", true, true}});
}

std::unique_ptr<Step> estop_wire_step() {
  return std::make_unique<SwitchStep>(
      Input::estop, StepInfo{"estop_wire", "e-stop's wire pulled", {"chip", "lines"}},
      "Watches the e-stop's line while its wire is off the board: it must read as pressed. Nothing moves.",
      std::vector<SwitchAct>{
          {Act::estop_release, "release the e-stop", false, false},
          {Act::estop_wire_off, "pull the wire of the e-stop's line off the board", true, true},
          {Act::estop_wire_on, "put the wire back", false, true}});
}

}  // namespace strobe::commission
