#include "sim/rig/truth.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"
#include "common/units/angles.hpp"
#include "sim/rig/tablet.hpp"

namespace strobe::sim {

namespace {

using nlohmann::json;
using reduction::Quantity;

json instant(MonoTime time) { return known(time) ? json(to_ns(time)) : json(nullptr); }

json readout_json(const reduction::Quantities& values) {
  json object = json::object();
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto& value = values[static_cast<Quantity>(i)];
    object[std::string(reduction::kQuantityNames[i])] = value ? json(*value) : json(nullptr);
  }
  return object;
}

json spatial_json(const reduction::Spatial& spatial) {
  json object = json::object();
  for (std::size_t i = 0; i < reduction::kSpatialCount; ++i)
    object[std::string(reduction::kSpatialNames[i])] = spatial.number[i]->value;
  return object;
}

json fault_names(const Scene& scene, const Exposure& exposure) {
  json names = json::array();
  for (const FaultKind kind : exposure.faults) names.push_back(std::string(name(kind)));
  for (const FaultKind kind : {FaultKind::no_photograph, FaultKind::frame_late, FaultKind::image_unseen}) {
    if (shot_fault(scene.faults, kind, exposure.shot)) names.push_back(std::string(name(kind)));
  }
  return names;
}

}  // namespace

reduction::Quantities true_readout(const Scene& scene, const BallPath& path) {
  const impact::Motion& td = path.touchdown();
  const impact::Motion& lo = path.rebound().lift_off;
  const double e = -lo.vy_mps / td.vy_mps;
  const double mu = (td.vx_mps - lo.vx_mps) / (lo.vy_mps - td.vy_mps);
  const double e_at_23_degC = e + 0.003 * (23.0 - scene.air.temperature_c);

  reduction::Quantities q;
  q[Quantity::theta_in_deg] = degrees(std::atan2(td.vy_mps, td.vx_mps));
  q[Quantity::theta_out_deg] = degrees(std::atan2(lo.vy_mps, lo.vx_mps));
  q[Quantity::vx_td_mps] = td.vx_mps;
  q[Quantity::vy_td_mps] = td.vy_mps;
  q[Quantity::v_td_mps] = std::hypot(td.vx_mps, td.vy_mps);
  q[Quantity::omega_td_radps] = td.omega_radps;
  q[Quantity::vx_lo_mps] = lo.vx_mps;
  q[Quantity::vy_lo_mps] = lo.vy_mps;
  q[Quantity::v_lo_mps] = std::hypot(lo.vx_mps, lo.vy_mps);
  q[Quantity::omega_lo_radps] = lo.omega_radps;
  q[Quantity::slip_lo_mps] = lo.vx_mps + scene.ball.radius_m() * lo.omega_radps;
  q[Quantity::e] = e;
  q[Quantity::mu] = mu;
  q[Quantity::dwell_time_ms] = path.dwell_s() * 1e3;
  q[Quantity::dwell_distance_cm] = path.dwell_distance_m() * 1e2;
  q[Quantity::court_pace] = 100.0 * (1.0 - mu) + 150.0 * (0.81 - e_at_23_degC);  // ITF CS 01/02
  return q;
}

reduction::Spatial true_spatial(const BallPath& path) {
  using enum reduction::SpatialQuantity;
  const ShotConditions& td = path.conditions();
  const LiftOff& lo = path.lift_off();
  const Eigen::Vector3d in(td.omega_x_radps, td.omega_y_radps, td.touchdown.omega_radps);
  const Eigen::Vector3d out(lo.omega_x_radps, lo.omega_y_radps, lo.rebound.lift_off.omega_radps);
  const auto tilt_deg = [](const Eigen::Vector3d& spin) {
    return degrees(std::atan2(std::hypot(spin.x(), spin.y()), std::abs(spin.z())));
  };
  reduction::Spatial spatial;
  const auto tell = [&](reduction::SpatialQuantity q, double value) {
    spatial[q] = reduction::DerivedNumber{.value = value};
  };
  tell(omega_x_td_radps, in.x());
  tell(omega_y_td_radps, in.y());
  tell(omega_z_td_radps, in.z());
  tell(spin_axis_tilt_td_deg, tilt_deg(in));
  tell(vz_td_mps, td.vz_mps);
  tell(omega_x_lo_radps, out.x());
  tell(omega_y_lo_radps, out.y());
  tell(omega_z_lo_radps, out.z());
  tell(spin_axis_tilt_lo_deg, tilt_deg(out));
  tell(vz_lo_mps, lo.vz_mps);
  tell(off_plane_mm, 1e3 * path.off_plane_m());
  return spatial;
}

std::string truth_line(const Scene& scene, const Exposure& exposure, int shot_id) {
  const bool ball = shows_impact(exposure);
  json line = {{"shot", exposure.shot}, {"shot_id", shot_id}, {"ball", ball}, {"throws", exposure.throws}};
  line["touchdown_ns"] = nullptr;
  line["liftoff_ns"] = nullptr;
  line["readout"] = nullptr;
  if (ball) {
    const BallPath& path = exposure.ball->path;
    line["touchdown_ns"] = to_ns(exposure.ball->touchdown);
    line["liftoff_ns"] = to_ns(exposure.ball->touchdown) + std::llround(path.dwell_s() * 1e9);
    line["readout"] = readout_json(true_readout(scene, path));
    if (!path.planar()) line["spatial"] = spatial_json(true_spatial(path));
  }
  line["opened_ns"] = instant(exposure.opened);
  line["closed_ns"] = instant(exposure.closed);
  line["flash_true_ns"] = json::array();
  for (const Pulse& pulse : exposure.pulses) line["flash_true_ns"].push_back(instant(flash_time(pulse)));
  line["image_flash"] = image_pulses(scene, exposure);
  line["faults"] = fault_names(scene, exposure);
  line["overrun"] = exposure.overrun;
  return messages::json_text(line);
}

}  // namespace strobe::sim
