// Key and e-stop, moved by a person, and a wire of each pulled: what the lines read must follow, and a line without its wire
// must read the safe way. Watches alone; nothing moves.
#pragma once

#include "host/commission/core/step.hpp"

namespace strobe::commission {

/// One thing to do, and how the line must read then.
struct SwitchAct {
  Act act = Act::none;
  std::string words;    ///< "turn the key on"
  bool level = false;   ///< the line must read: key on, e-stop pressed
  bool change = false;  ///< it must be seen to change; false: it may read so already
};

class SwitchStep final : public Step {
 public:
  enum class Input { key, estop };
  static SwitchStep key();
  static SwitchStep key_wire();
  static SwitchStep estop();
  static SwitchStep estop_wire();

  const std::vector<StepInfo>& infos() const override { return infos_; }
  Needs needs() const override { return {.operator_acts = true}; }
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

  SwitchStep(Input input, StepInfo info, std::string briefing, std::vector<SwitchAct> acts);
  void take_status(const Situation& situation);
  void enter(std::size_t act, HostTime now);
  bool reads(bool level, HostTime now) const;
  std::string other_name() const { return input_ == Input::key ? "e-stop" : "key"; }
  std::string own_name() const { return input_ == Input::key ? "key" : "e-stop"; }
  std::string in_words(bool level) const;
  StepResult swapped() const;
  StepResult inverted() const;
  StepResult unmoved(const Situation& situation) const;
  StepResult passed() const;

  Input input_;
  std::vector<StepInfo> infos_;
  std::string briefing_;
  std::vector<SwitchAct> acts_;
  bool wire_ = false;
  std::size_t act_ = 0;
  bool probing_ = false;  ///< the first state was not reached: does the line move at all, and which way?
  HostTime entered_;
  Line own_, other_;
  int bounces_ = 0;
};

}  // namespace strobe::commission
