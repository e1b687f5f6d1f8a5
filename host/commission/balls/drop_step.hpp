// Balls dropped by hand from about a metre, photographed by a slow train: gravity as measured against the place's, and the
// plate's inclination. The machine stays still. Single-threaded; photographs are measured on threads of their own.
#pragma once

#include <vector>

#include "host/commission/camera/measured_pictures.hpp"
#include "host/commission/core/shot_collector.hpp"
#include "host/commission/core/step.hpp"

namespace strobe::commission {

class DropStep final : public Step {
 public:
  const std::vector<StepInfo>& infos() const override;
  Needs needs() const override { return {.operator_acts = true, .outputs = true, .photographs = true}; }
  std::string briefing(const host::RigFile& rig) const override;
  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;
  void on_shot(FiredShot shot) override;
  void on_no_shot(const std::string& why) override { shots_.give_up(why); }

 private:
  std::vector<StepResult> judge(const Situation& situation);

  const host::RigFile* rig_ = nullptr;  ///< as it was when the step began
  ShotCollector shots_;
  MeasuredPictures pictures_;
  bool photograph_missing_ = false;
};

}  // namespace strobe::commission
