// The lamps' light on the picture: five dry shots with photographs. Single-threaded; decodes photographs as it judges.
#pragma once

#include <vector>

#include "host/commission/core/shot_collector.hpp"
#include "host/commission/core/step.hpp"

namespace strobe::commission {

class LightStep final : public Step {
 public:
  const std::vector<StepInfo>& infos() const override;
  Needs needs() const override { return {.outputs = true, .photographs = true}; }
  std::string briefing(const host::RigFile& rig) const override;
  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;
  void on_shot(FiredShot shot) override;
  void on_no_shot(const std::string& why) override { shots_.give_up(why); }

 private:
  std::vector<StepResult> judge(const Situation& situation) const;

  ShotCollector shots_;
  bool photograph_missing_ = false;
};

/// Why there is no photograph of a shot, for every step that needs one.
StepResult no_photograph(const std::string& id, const host::RigFile& rig);

}  // namespace strobe::commission
