#include "tests/soak/fault_plan.hpp"

#include <fstream>
#include <sstream>

#include "common/config/toml_reader.hpp"

namespace strobe::soak {

using sim::Fault;
using sim::FaultKind;

FaultPlan no_faults() { return {}; }

FaultPlan mild_faults() {
  FaultPlan plan;
  plan.name = "mild";
  for (double& p : plan.rig) p = 0.003;
  for (double& p : plan.hazard) p = 0.003;
  plan[Hazard::loop_freeze] = plan[Hazard::loop_delay] = 0.01;
  plan.packet_loss = 0.005;
  plan.packet_duplication = 0.005;
  plan.packet_reordering = 0.01;
  return plan;
}

FaultPlan wild_faults() {
  FaultPlan plan;
  plan.name = "wild";
  for (double& p : plan.rig) p = 0.03;
  for (double& p : plan.hazard) p = 0.03;
  plan[FaultKind::frame_late] = plan[FaultKind::no_photograph] = 0.01;
  plan[Hazard::firmware_hang] = 0.005;
  plan[Hazard::command_replay] = 0.3;
  plan[Hazard::loop_delay] = 0.15;
  plan.packet_loss = 0.1;
  plan.packet_duplication = 0.05;
  plan.packet_reordering = 0.1;
  plan.strangers = 0.05;
  return plan;
}

FaultPlan stop_faults() {
  FaultPlan plan;
  plan.name = "stops";
  for (const Hazard stop : {Hazard::key_off, Hazard::estop, Hazard::ctrl_c, Hazard::stop_at_once,
                            Hazard::page_disarm, Hazard::firmware_suspend, Hazard::host_suspend})
    plan[stop] = 0.06;
  plan[Hazard::other_series] = 0.15;
  plan[Hazard::network_outage] = 0.05;
  plan[Hazard::command_replay] = 0.3;
  plan[Hazard::loop_freeze] = plan[Hazard::loop_delay] = 0.03;
  plan[Hazard::firmware_kill] = plan[Hazard::firmware_stop] = plan[Hazard::host_kill] = 0.01;
  plan.packet_loss = 0.2;
  plan.packet_duplication = 0.1;
  plan.packet_reordering = 0.2;
  return plan;
}

Result<FaultPlan> read_fault_plan(std::string_view text, const std::string& file_name) {
  config::TomlReader reader(text, file_name);
  config::TomlTable root = reader.root();
  constexpr config::Range kProbability{0.0, 1.0};
  FaultPlan plan;
  plan.name = file_name;
  for (std::size_t i = 0; i < plan.rig.size(); ++i)
    plan.rig[i] = root.number_or(sim::kFaultNames[i], 0.0, kProbability);
  for (std::size_t i = 0; i < plan.hazard.size(); ++i)
    plan.hazard[i] = root.number_or(kHazardNames[i], 0.0, kProbability);
  plan.packet_loss = root.number_or("packet_loss", 0.0, {0.0, 0.9});
  plan.packet_duplication = root.number_or("packet_duplication", 0.0, kProbability);
  plan.packet_reordering = root.number_or("packet_reordering", 0.0, kProbability);
  plan.strangers = root.number_or("strangers", 0.0, kProbability);
  plan.played_back = root.number_or("played_back", 0.0, kProbability);
  if (auto bad = reader.error()) return fail(bad->message);
  return plan;
}

Result<FaultPlan> find_fault_plan(const std::string& word) {
  if (word == "none") return no_faults();
  if (word == "mild") return mild_faults();
  if (word == "wild") return wild_faults();
  if (word == "stops") return stop_faults();
  std::ifstream file(word);
  if (!file) return fail(word + ": neither none, mild, wild or stops nor a file that can be read");
  std::ostringstream text;
  text << file.rdbuf();
  return read_fault_plan(text.str(), word);
}

namespace {

bool of_one_flash(FaultKind kind) {
  return kind == FaultKind::flash_late || kind == FaultKind::flash_missing ||
         kind == FaultKind::flash_double || kind == FaultKind::flash_dim ||
         kind == FaultKind::sensor_dropout || kind == FaultKind::sensor_bounce ||
         kind == FaultKind::image_unseen;
}

Duration delay_of(FaultKind kind, Random& random) {
  if (kind == FaultKind::frame_late) return random.between(milliseconds(100), milliseconds(7000));
  if (kind == FaultKind::gate_chatter) return random.between(microseconds(20), milliseconds(3));
  return nanoseconds(std::llround(random.log_uniform(10e3, 2.5e6)));
}

Fault draw_fault(FaultKind kind, int shot, Random& random) {
  Fault fault;
  fault.kind = kind;
  fault.shot = shot;
  if (of_one_flash(kind)) {
    const int place = random.integer(1, 6);
    fault.flash_from_impact = random.chance(0.5) ? place : -place;
  }
  const int lamps = random.integer(0, 2);
  fault.lamp_a = lamps != 1;
  fault.lamp_b = lamps != 0;
  fault.delay = delay_of(kind, random);
  return fault;
}

}  // namespace

std::vector<Fault> draw_rig_faults(const FaultPlan& plan, int shots, Random& random) {
  std::vector<Fault> faults;
  for (int shot = 1; shot <= shots; ++shot) {
    for (std::size_t i = 0; i < plan.rig.size(); ++i)
      if (random.chance(plan.rig[i])) faults.push_back(draw_fault(static_cast<FaultKind>(i), shot, random));
  }
  return faults;
}

}  // namespace strobe::soak
