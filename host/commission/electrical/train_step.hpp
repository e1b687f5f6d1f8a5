// Steps that fire dry trains and judge them: lamps and shutter. The machine's trigger stays inactive.
#pragma once

#include <functional>

#include "host/commission/core/shot_collector.hpp"
#include "host/commission/core/step.hpp"

namespace strobe::commission {

class TrainStep final : public Step {
 public:
  static TrainStep lamp_a();
  static TrainStep lamp_b();
  static TrainStep lamps_together();
  static TrainStep shutter();

  const std::vector<StepInfo>& infos() const override { return infos_; }
  Needs needs() const override { return {.outputs = true}; }
  std::string briefing(const host::RigFile& rig) const override;
  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;
  void on_shot(FiredShot shot) override { shots_.add(std::move(shot)); }
  void on_no_shot(const std::string& why) override { shots_.give_up(why); }

 private:
  using Judge = StepResult (*)(const std::string& id, const std::vector<FiredShot>& shots,
                               const host::RigFile& rig);
  TrainStep(StepInfo info, Lamps lamps, int trains, int flashes, std::string what, Judge judge);

  std::vector<StepInfo> infos_;
  Lamps lamps_;
  int trains_, flashes_;
  std::string what_;
  Judge judge_;
  ShotCollector shots_;
};

}  // namespace strobe::commission
