#include "host/commission/electrical/train_step.hpp"

#include <fmt/format.h>

#include "host/commission/electrical/lamp_judgement.hpp"
#include "host/commission/electrical/shutter_judgement.hpp"
#include "host/commission/electrical/train_plan.hpp"

namespace strobe::commission {
namespace {

/// The mean of a hundred delays with 1 us of jitter is known to 0.1 us; a flash missed in one of 33 is missed in a
/// hundred with 95 % probability.
constexpr int kLampFlashes = 100;
constexpr int kShutterTrains = 5;
constexpr int kShutterFlashes = 50;  // so that the exposure outlasts any lag

const std::vector<std::string> kLampTables{"chip", "lines", "lamps", "sensors"};

StepResult judge_a(const std::string& id, const std::vector<FiredShot>& shots, const host::RigFile& rig) {
  return judge_lamp_alone(id, Lamps::a, shots.front().shot, rig.commission);
}
StepResult judge_b(const std::string& id, const std::vector<FiredShot>& shots, const host::RigFile& rig) {
  return judge_lamp_alone(id, Lamps::b, shots.front().shot, rig.commission);
}
StepResult judge_both(const std::string& id, const std::vector<FiredShot>& shots, const host::RigFile& rig) {
  return judge_lamps_together(id, shots.front().shot, rig.commission);
}
StepResult judge_shots_shutter(const std::string& id, const std::vector<FiredShot>& fired,
                               const host::RigFile& rig) {
  std::vector<strobe_msgs::shot_t> shots;
  for (const FiredShot& shot : fired) shots.push_back(shot.shot);
  return judge_shutter(id, shots, rig);
}

}  // namespace

TrainStep::TrainStep(StepInfo info, Lamps lamps, int trains, int flashes, std::string what, Judge judge)
    : infos_{std::move(info)},
      lamps_(lamps),
      trains_(trains),
      flashes_(flashes),
      what_(std::move(what)),
      judge_(judge) {}

TrainStep TrainStep::lamp_a() {
  return {{"lamp_a", "lamp A alone", kLampTables}, Lamps::a, 1, kLampFlashes, "lamp A alone", judge_a};
}
TrainStep TrainStep::lamp_b() {
  return {{"lamp_b", "lamp B alone", kLampTables}, Lamps::b, 1, kLampFlashes, "lamp B alone", judge_b};
}
TrainStep TrainStep::lamps_together() {
  return {{"lamps_together", "both lamps together", kLampTables},
          Lamps::both,
          1,
          kLampFlashes,
          "both lamps",
          judge_both};
}
TrainStep TrainStep::shutter() {
  return {{"shutter", "the shutter's lag", {"chip", "lines", "shutter"}},
          Lamps::both,
          kShutterTrains,
          kShutterFlashes,
          "both lamps",
          judge_shots_shutter};
}

std::string TrainStep::briefing(const host::RigFile& rig) const {
  const auto flashes = dry_train(rig, lamps_, flashes_).code.size();
  return fmt::format(
      "FLASHES: {} flash{} {} times{}, and the shutter opens; the machine's trigger stays still. Key on, "
      "e-stop "
      "released.{}",
      what_, lamps_ == Lamps::both ? "" : "es", flashes,
      trains_ > 1 ? fmt::format(", in each of {} trains", trains_) : "",
      lamps_ == Lamps::both ? "" : " Look which lamp it is.");
}

void TrainStep::begin(const Situation& situation) {
  Fire fire;
  fire.plan = dry_train(situation.rig, lamps_, flashes_);
  fire.words = fmt::format("{}: {} flashes", what_, fire.plan.code.size());
  shots_ = ShotCollector(std::vector<Fire>(static_cast<std::size_t>(trains_), fire));
}

Request TrainStep::step(const Situation& situation) {
  if (const Fire* const wanted = shots_.next()) return *wanted;
  if (!shots_.problem().empty())
    return Done{
        {failed(infos_[0].id, "no_shot", shots_.problem(), "mend what it names, and run the step again")}};
  return Done{{judge_(infos_[0].id, shots_.shots(), situation.rig)}};
}

}  // namespace strobe::commission
