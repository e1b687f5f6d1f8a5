// A few balls thrown by the machine: focus, exposure and linearity of their photographs, flashes against images, scale and
// squareness by the balls' size, noise, repeatability. Single-threaded; photographs are measured on threads of their own.
#pragma once

#include <vector>

#include "host/commission/balls/ball_judgement.hpp"
#include "host/commission/camera/measured_pictures.hpp"
#include "host/commission/core/shot_collector.hpp"
#include "host/commission/core/step.hpp"

namespace strobe::commission {

class BallsStep final : public Step {
 public:
  const std::vector<StepInfo>& infos() const override;
  Needs needs() const override {
    return {.operator_acts = true, .outputs = true, .machine = true, .photographs = true};
  }
  std::string briefing(const host::RigFile& rig) const override;
  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;
  void on_event(const strobe_msgs::event_t& event, HostTime now) override;
  void on_shot(FiredShot shot) override;
  void on_no_shot(const std::string& why) override { shots_.give_up(why); }

 private:
  std::vector<StepResult> judge(const Situation& situation);
  std::vector<StepResult> all_skipped(StepResult first) const;

  const host::RigFile* rig_ = nullptr;  ///< as it was when the step began
  ShotCollector shots_;
  MeasuredPictures pictures_;
  std::vector<std::size_t> pictured_;  ///< of each picture its shot
  std::vector<int> gate_edges_;        ///< of each shot
  int edges_ = 0;                      ///< since the last one
  int without_photograph_ = 0;
};

}  // namespace strobe::commission
