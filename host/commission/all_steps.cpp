#include "host/commission/all_steps.hpp"

#include "host/commission/balls/balls_step.hpp"
#include "host/commission/balls/drop_step.hpp"
#include "host/commission/camera/board_step.hpp"
#include "host/commission/camera/light_step.hpp"
#include "host/commission/electrical/firmware_step.hpp"
#include "host/commission/electrical/switch_step.hpp"
#include "host/commission/electrical/train_step.hpp"
#include "host/commission/electrical/trigger_step.hpp"

namespace strobe::commission {

std::vector<std::unique_ptr<Step>> all_steps() {
  std::vector<std::unique_ptr<Step>> steps;
  steps.push_back(std::make_unique<FirmwareStep>());
  steps.push_back(std::make_unique<SwitchStep>(SwitchStep::key()));
  steps.push_back(std::make_unique<SwitchStep>(SwitchStep::key_wire()));
  steps.push_back(std::make_unique<SwitchStep>(SwitchStep::estop()));
  steps.push_back(std::make_unique<SwitchStep>(SwitchStep::estop_wire()));
  steps.push_back(std::make_unique<TrainStep>(TrainStep::lamp_a()));
  steps.push_back(std::make_unique<TrainStep>(TrainStep::lamp_b()));
  steps.push_back(std::make_unique<TrainStep>(TrainStep::lamps_together()));
  steps.push_back(std::make_unique<TrainStep>(TrainStep::shutter()));
  steps.push_back(std::make_unique<LightStep>());
  steps.push_back(std::make_unique<BoardStep>());
  steps.push_back(std::make_unique<DropStep>());
  steps.push_back(std::make_unique<TriggerStep>());
  steps.push_back(std::make_unique<BallsStep>());
  return steps;
}

std::vector<StepInfo> all_infos() {
  std::vector<StepInfo> infos;
  for (const auto& step : all_steps()) infos.insert(infos.end(), step->infos().begin(), step->infos().end());
  return infos;
}

}  // namespace strobe::commission
