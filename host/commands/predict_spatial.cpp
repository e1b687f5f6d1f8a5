#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "common/impact/spatial/spatial_contact.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/units/angles.hpp"
#include "host/commands/command.hpp"
#include "host/commands/prediction.hpp"

namespace strobe::host::prediction {

namespace {

using nlohmann::ordered_json;

struct SpatialPrediction {
  impact::SpatialMotion touchdown, lift_off;
  Regime regime = Regime::slides;
  Eigen::Vector2d slip_td_mps, slip_lo_mps;
  std::optional<impact::SpatialLiftOff> contact = std::nullopt;

  double impulse_ratio() const {
    const Eigen::Vector3d change = lift_off.velocity_mps - touchdown.velocity_mps;
    return std::hypot(change.x(), change.z()) / change.y();
  }
};

tl::expected<SpatialPrediction, impact::InputError> predicted(const PredictOptions& o) {
  const ball::Ball ball = ball_of(o);
  const impact::SpatialMotion td{{o.touchdown.vx_mps, o.touchdown.vy_mps, o.vz_mps},
                                 {o.omega_x_radps, o.omega_y_radps, o.touchdown.omega_radps}};
  const auto of = [&](const impact::SpatialMotion& lo, Regime regime) {
    return SpatialPrediction{td, lo, regime, impact::slip_mps(ball, td), impact::slip_mps(ball, lo)};
  };
  if (o.model == "ode")
    return impact::SpatialContact::make(ball, td, contact_of(o), o.integration.tolerance)
        .map([&](const impact::SpatialContact& c) {
          SpatialPrediction out = of(c.lift_off().motion, c.lift_off().regime);
          out.contact = c.lift_off();
          return out;
        });
  return (o.model == "rigid" ? impact::rigid(ball, td, o.e, mu_of(o)) : impact::grip(ball, td, grip_of(o)))
      .map([&](const impact::SpatialRebound& r) { return of(r.lift_off, impact::regime_of(ball, td, r)); });
}

double out_deg(const impact::SpatialMotion& m) {
  return degrees(std::atan2(m.velocity_mps.y(), std::hypot(m.velocity_mps.x(), m.velocity_mps.z())));
}

/// From x towards z; nullopt where but rounding is left.
std::optional<double> direction_deg(const Eigen::Vector2d& slip_mps) {
  if (slip_mps.norm() < 1e-9) return std::nullopt;
  return degrees(std::atan2(slip_mps.y(), slip_mps.x()));
}

ordered_json direction_json(const Eigen::Vector2d& slip_mps) {
  const auto direction = direction_deg(slip_mps);
  return direction ? ordered_json(*direction) : ordered_json();
}

std::string direction_text(const Eigen::Vector2d& slip_mps) {
  const auto direction = direction_deg(slip_mps);
  return direction ? fmt::format("{:.1f} degrees from x towards z", *direction) : "nowhere";
}

void print_spatial_json(const PredictOptions& o, const SpatialPrediction& p) {
  const Eigen::Vector3d &v = p.lift_off.velocity_mps, &omega = p.lift_off.spin_radps;
  ordered_json out{{"theta_out_deg", out_deg(p.lift_off)},
                   {"vx_lo_mps", v.x()},
                   {"vy_lo_mps", v.y()},
                   {"vz_lo_mps", v.z()},
                   {"v_lo_mps", v.norm()},
                   {"omega_x_lo_radps", omega.x()},
                   {"omega_y_lo_radps", omega.y()},
                   {"omega_lo_radps", omega.z()},
                   {"slip_direction_td_deg", direction_json(p.slip_td_mps)},
                   {"slip_direction_lo_deg", direction_json(p.slip_lo_mps)},
                   {"slip_lo_mps", p.slip_lo_mps.norm()},
                   {"mu", p.impulse_ratio()},
                   {"regime", name(p.regime)}};
  if (p.contact) {
    out["skid_to_grip_ms"] = milliseconds_json(p.contact->skid_to_grip_s);
    out["dwell_time_ms"] = p.contact->time_s * 1e3;
    out["dwell_distance_cm"] = p.contact->displacement_m.x() * 1e2;
    out["dwell_distance_z_cm"] = p.contact->displacement_m.z() * 1e2;
    out["energy"] = energy_json(p.contact->energy);
  }
  out["inputs"] = inputs_of(o);
  out["inputs"]["vz_mps"] = o.vz_mps;
  out["inputs"]["omega_x_radps"] = o.omega_x_radps;
  out["inputs"]["omega_y_radps"] = o.omega_y_radps;
  out["inputs"].erase("method");
  if (!o.remarks.empty()) out["remarks"] = o.remarks;
  std::printf("%s\n", messages::json_text(out).c_str());
}

void print_spatial_table(const PredictOptions& o, const SpatialPrediction& p) {
  print_model(o);
  std::printf(
      "\n             vx m/s    vy m/s    vz m/s angle deg   spin rad/s: x           y           z\n");
  for (const auto& [when, m] : {std::pair("touchdown", &p.touchdown), std::pair("lift-off", &p.lift_off)})
    std::printf("%-10s %8.3f  %8.3f  %8.3f  %8.2f  %13.2f %11.2f %11.2f\n", when, m->velocity_mps.x(),
                m->velocity_mps.y(), m->velocity_mps.z(), out_deg(*m), m->spin_radps.x(), m->spin_radps.y(),
                m->spin_radps.z());
  std::printf("%s; slips %s, at lift-off by %.3f m/s %s; impulse ratio %.4f\n", name(p.regime).data(),
              direction_text(p.slip_td_mps).c_str(), p.slip_lo_mps.norm(),
              direction_text(p.slip_lo_mps).c_str(), p.impulse_ratio());
}

}  // namespace

int predict_spatial(const PredictOptions& o) {
  const auto p = predicted(o);
  if (!p) return bad_input("predict: " + std::string(impact::message(p.error())));
  o.json ? print_spatial_json(o, *p) : print_spatial_table(o, *p);
  return kDone;
}

}  // namespace strobe::host::prediction
