#include "host/commands/predict/predict_ode.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/units/angles.hpp"

namespace strobe::host {

namespace {

using nlohmann::ordered_json;

ordered_json milliseconds_json(const std::optional<double>& time_s) {
  return time_s ? ordered_json(*time_s * 1e3) : ordered_json(nullptr);
}

ordered_json energy_json(const impact::ContactEnergy& e) {
  return {{"kinetic_td_j", e.kinetic_td_j},
          {"kinetic_lo_j", e.kinetic_lo_j},
          {"kinetic_lost_j", e.kinetic_lost_j},
          {"normal_damping_j", e.normal_damping_j},
          {"normal_spring_left_j", e.normal_spring_left_j},
          {"sliding_j", e.sliding_j},
          {"tangential_damping_j", e.tangential_damping_j},
          {"tangential_spring_left_j", e.tangential_spring_left_j},
          {"offset_j", e.offset_j},
          {"gravity_work_j", e.gravity_work_j}};
}

/// The i-th of n states, equally spaced in time.
impact::ContactState sample(const impact::ContactTrajectory& contact, int i, int n) {
  return contact.at(n > 1 ? contact.summary().dwell_s * i / (n - 1) : 0.0);
}

ordered_json state_json(const impact::ContactState& s) {
  return {{"time_ms", s.time_s * 1e3},
          {"x_m", s.x_m},
          {"y_m", s.y_m},
          {"angle_deg", degrees(s.rotation_rad)},
          {"vx_mps", s.vx_mps},
          {"vy_mps", s.vy_mps},
          {"omega_radps", s.omega_radps},
          {"fx_n", s.fx_n},
          {"fy_n", s.fy_n},
          {"mode", impact::name(s.mode)}};
}

}  // namespace

void add_contact_json(ordered_json& out, const impact::ContactTrajectory& contact, int samples) {
  const impact::ContactSummary& s = contact.summary();
  out["skid_to_grip_ms"] = milliseconds_json(s.skid_to_grip_s);
  out["slip_zero_ms"] = milliseconds_json(s.slip_zero_s);
  out["friction_reversals"] = s.friction_reversals;
  out["dwell_time_ms"] = s.dwell_s * 1e3;
  out["dwell_distance_cm"] = s.dwell_distance_m * 1e2;
  out["rotation_deg"] = degrees(s.rotation_rad);
  out["depth_m"] = s.max_depth_m;
  out["depth_time_ms"] = s.max_depth_time_s * 1e3;
  out["force_max_n"] = s.max_force_n;
  out["force_max_time_ms"] = s.max_force_time_s * 1e3;
  out["friction_max_n"] = s.max_friction_n;
  out["mean_offset_mm"] = s.mean_offset_m * 1e3;
  out["events"] = ordered_json::array();
  for (const impact::ContactEvent& event : s.event_list())
    out["events"].push_back({{"time_ms", event.time_s * 1e3}, {"event", impact::name(event.kind)}});
  out["energy"] = energy_json(s.energy);
  out["steps"] = s.steps;
  out["method"] = impact::name(s.method);
  if (samples == 0) return;
  out["trajectory"] = ordered_json::array();
  for (int i = 0; i < samples; ++i) out["trajectory"].push_back(state_json(sample(contact, i, samples)));
}

void print_contact(const impact::ContactTrajectory& contact) {
  const impact::ContactSummary& s = contact.summary();
  std::printf("contact of %.3f ms: %.1f mm deep, %.2f cm along, turned %.1f degrees, %.0f N at most\n",
              s.dwell_s * 1e3, s.max_depth_m * 1e3, s.dwell_distance_m * 1e2, degrees(s.rotation_rad),
              s.max_force_n);
  for (const impact::ContactEvent& event : s.event_list())
    std::printf("  %8.4f ms  %s\n", event.time_s * 1e3, impact::name(event.kind).data());
  const impact::ContactEnergy& e = s.energy;
  std::printf(
      "energy %.4f J, of which lost: %.4f normal damping, %.4f sliding, %.4f tangential damping, %.4f "
      "offset,\n"
      "  %.4f and %.4f left in the normal and tangential springs; sum %.4f of %.4f\n",
      e.kinetic_td_j, e.normal_damping_j, e.sliding_j, e.tangential_damping_j, e.offset_j,
      e.normal_spring_left_j, e.tangential_spring_left_j, e.dissipated_j(), e.kinetic_lost_j);
}

std::string contact_csv(const impact::ContactTrajectory& contact, int samples) {
  std::string out = "time_ms,x_m,y_m,angle_deg,vx_mps,vy_mps,omega_radps,fx_n,fy_n,mode\n";
  for (int i = 0; i < samples; ++i) {
    const impact::ContactState s = sample(contact, i, samples);
    out +=
        fmt::format("{},{},{},{},{},{},{},{},{},{}\n", s.time_s * 1e3, s.x_m, s.y_m, degrees(s.rotation_rad),
                    s.vx_mps, s.vy_mps, s.omega_radps, s.fx_n, s.fy_n, impact::name(s.mode));
  }
  return out;
}

}  // namespace strobe::host
