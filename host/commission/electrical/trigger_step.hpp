// The machine's trigger, without a ball: one pulse of the right length in a shot, and a click that a person hears.
#pragma once

#include <vector>

#include "host/commission/core/step.hpp"

namespace strobe::commission {

class TriggerStep final : public Step {
 public:
  const std::vector<StepInfo>& infos() const override;
  Needs needs() const override { return {.operator_acts = true, .outputs = true, .machine = true}; }
  std::string briefing(const host::RigFile& rig) const override;
  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;
  void on_event(const strobe_msgs::event_t& event, HostTime now) override;
  void on_shot(FiredShot shot) override;
  void on_no_shot(const std::string& why) override { problem_ = why; }
  void on_answer(bool yes) override { heard_ = yes; }

 private:
  StepResult judge(const Situation& situation) const;
  int rises(const strobe_msgs::shot_t& shot) const;

  Fire fire_;
  std::optional<strobe_msgs::shot_t> shot_;
  int repeated_ = 0;
  std::string problem_;
  std::vector<strobe_msgs::event_t> pulses_;
  std::optional<bool> heard_;  ///< the click; absent: not asked yet
};

}  // namespace strobe::commission
