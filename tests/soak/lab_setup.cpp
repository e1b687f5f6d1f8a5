#include "tests/soak/lab_setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "common/config/toml_reader.hpp"

namespace strobe::soak {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

void draw_ball(sim::Scene& scene, Random& random) {
  // Rule 3's tolerance, as the rig file states it by its standard deviation.
  scene.ball.diameter_m = 0.0651 + random.uniform(-1.0, 1.0) * std::sqrt(3.0) * 0.0008;
  scene.ball.mass_kg = 0.0576;
  sim::BounceSettings& bounce = scene.bounce;
  bounce.e = random.uniform(0.70, 0.88);
  bounce.e_speed_mps = std::abs(scene.machine.speed_mps * std::sin(scene.machine.angle_rad));
  bounce.e_sd = 0.01;
  bounce.mu = random.uniform(0.35, 0.70);
  bounce.mu_sd = 0.02;
  bounce.dwell_s = random.uniform(0.004, 0.0056);
  bounce.dwell_sd_s = 0.0001;
  bounce.offset_share_sd = 0.02;
}

void draw_shot_conditions(sim::Scene& scene, Random& random, double speed_mps, double angle_rad,
                          double spin_radps) {
  sim::MachineSettings& machine = scene.machine;
  machine.speed_mps = speed_mps;
  machine.speed_sd_mps = 0.02 * speed_mps;
  machine.angle_rad = angle_rad;
  machine.angle_sd_rad = 0.3 * kDegree;
  machine.spin_radps = spin_radps;
  machine.spin_sd_radps = 10.0;
  machine.lag_sd_s = random.uniform(0.0005, 0.004);
}

void draw_shot_conditions(sim::Scene& scene, Random& random) {
  draw_shot_conditions(scene, random, random.uniform(12.0, 34.0), -random.uniform(15.0, 72.0) * kDegree,
                       random.uniform(-350.0, 350.0));
}

void draw_extreme_throw(sim::Scene& scene, Random& random) {
  const double angle = -random.uniform(17.0, 60.0) * kDegree;
  switch (random.integer(0, 5)) {
    case 0:
      return draw_shot_conditions(scene, random, random.uniform(1.2, 5.0), angle,
                                  random.uniform(-100.0, 100.0));
    case 1:
      return draw_shot_conditions(scene, random, random.uniform(40.0, 58.0), angle,
                                  random.uniform(-300.0, 300.0));
    case 2:
      return draw_shot_conditions(scene, random, random.uniform(12.0, 35.0),
                                  -random.uniform(5.2, 10.0) * kDegree, random.uniform(-300.0, 300.0));
    case 3:
      return draw_shot_conditions(scene, random, random.uniform(10.0, 25.0),
                                  -random.uniform(78.0, 84.5) * kDegree, random.uniform(-200.0, 200.0));
    case 4:
      return draw_shot_conditions(scene, random, random.uniform(12.0, 30.0), angle,
                                  (random.chance(0.5) ? 1.0 : -1.0) * random.uniform(450.0, 950.0));
    default:
      return draw_shot_conditions(scene, random, random.uniform(25.0, 40.0),
                                  -random.uniform(40.0, 70.0) * kDegree, random.uniform(-200.0, 200.0));
  }
}

void draw_camera(LabSetup& lab_setup, Random& random) {
  sim::Scene& scene = lab_setup.scene;
  scene.camera.roll_rad = random.uniform(-1.0, 1.0) * kDegree;
  scene.camera.mirrored = random.chance(0.2);
  scene.tablet.centre_sd_m = random.uniform(0.0002, 0.0005);
  scene.tablet.equator_sd_rad = random.uniform(0.2, 1.0) * kDegree;
  if (random.chance(0.3)) scene.tablet.calibration_sd = random.log_uniform(1e-4, 1e-2);
  if (random.chance(0.3)) scene.surface_angle_rad = random.uniform(-10.0, 10.0) * kDegree;
}

/// So that the ball advances by a third to nearly two of its diameters between images.
double period_us(const sim::Scene& scene, Random& random) {
  const double step_m = random.uniform(0.022, 0.055);
  // Whoever expects much spin flashes faster: up to a little more than a quarter turn between images.
  const double turn_rad = random.uniform(0.5, 1.1) * std::numbers::pi / 2.0;
  const double spin_radps = std::max(50.0, std::abs(scene.machine.spin_radps));
  return std::clamp(1e6 * std::min(step_m / scene.machine.speed_mps, turn_rad / spin_radps), 1500.0, 6000.0);
}

milliseconds rounded_ms(double ms) { return milliseconds{std::llround(ms)}; }
double in_ms(Duration duration) { return std::chrono::duration<double, std::milli>(duration).count(); }

void plan_brief(LabSetup& lab_setup, Random& random) {
  ShotPlan& plan = lab_setup.plan.even;
  plan.period = microseconds{std::llround(period_us(lab_setup.scene, random))};
  plan.exposure = rounded_ms(random.uniform(70.0, 110.0));
  plan.impact_at = rounded_ms(random.uniform(0.45, 0.55) * in_ms(plan.exposure));
}

void plan_gated(LabSetup& lab_setup, Random& random) {
  ShotPlan& plan = lab_setup.plan.even;
  plan_brief(lab_setup, random);
  plan.train = Train::gated;
  plan.flash_count = random.integer(14, 24);
  const double vx_mps = lab_setup.scene.machine.speed_mps * std::cos(lab_setup.scene.machine.angle_rad);
  const double arrival_ms = 1e3 * (lab_setup.scene.gate.distance_m + 0.03) / vx_mps;
  const double before_ms = 0.45 * in_ms(plan.period) * plan.flash_count;
  plan.gate_delay = std::max(milliseconds{0}, rounded_ms(arrival_ms - before_ms));
  // The gate is passed before the impact by the arrival's time; the burst must end within the exposure.
  plan.impact_at = rounded_ms(arrival_ms + 20.0);
  plan.exposure = rounded_ms(in_ms(plan.impact_at + plan.period * plan.flash_count) + 30.0);
}

void plan_coded(LabSetup& lab_setup, Random& random) {
  host::PlanFile& plan = lab_setup.plan;
  plan_brief(lab_setup, random);
  const auto shortest_us = static_cast<double>(plan.even.period / microseconds{1});
  for (int k = random.integer(2, 7); k > 0; --k)
    plan.intervals.push_back(microseconds{std::llround(shortest_us * (1.0 + 0.1 * random.integer(0, 2)))});
  plan.intervals.push_back(plan.even.period);
  // 11 at the least: 70 ms at 6 ms, a fifth longer.
  const int flashes = static_cast<int>(1000.0 * in_ms(plan.even.exposure) / (1.2 * shortest_us));
  for (int k = random.integer(0, 3); k < flashes; k += random.integer(5, 12)) {
    auto& list = random.chance(0.3) ? plan.omit : random.chance(0.5) ? plan.only_a : plan.only_b;
    list.push_back(k);
  }
}

bool can_be_gated(const sim::Scene& scene) {
  return scene.machine.speed_mps * std::cos(scene.machine.angle_rad) > 8.0;
}

}  // namespace

LabSetup draw_lab_setup(PlanKind kind, const host::PlanFile& shipped, Random& random) {
  LabSetup lab_setup;
  lab_setup.scene.name = "drawn";
  if (kind == PlanKind::extremes)
    draw_extreme_throw(lab_setup.scene, random);
  else
    draw_shot_conditions(lab_setup.scene, random);
  draw_ball(lab_setup.scene, random);
  draw_camera(lab_setup, random);
  lab_setup.plan = shipped;
  const double which = random.uniform();
  const bool any = kind == PlanKind::mixed || kind == PlanKind::extremes;
  const bool gated = kind == PlanKind::gated || (any && which < 0.1);
  const bool as_shipped = kind == PlanKind::shipped || (any && which > 0.9);
  if (gated && can_be_gated(lab_setup.scene))
    plan_gated(lab_setup, random);
  else if (kind == PlanKind::coded)
    plan_coded(lab_setup, random);
  else if (!as_shipped)
    plan_brief(lab_setup, random);
  lab_setup.notes = {{"surface_angle_deg", fmt::format("{}", lab_setup.scene.surface_angle_rad / kDegree)},
                     {"temperature_c", fmt::format("{}", lab_setup.scene.air.temperature_c)}};
  return lab_setup;
}

Result<PlanKind> find_plan_kind(std::string_view word) {
  if (word == "shipped") return PlanKind::shipped;
  if (word == "brief") return PlanKind::brief;
  if (word == "gated") return PlanKind::gated;
  if (word == "coded") return PlanKind::coded;
  if (word == "mixed") return PlanKind::mixed;
  if (word == "extremes") return PlanKind::extremes;
  return fail(std::string(word) + ": not one of shipped, brief, gated, coded, mixed, extremes");
}


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
