#include <fmt/format.h>

#include "sim/fit/fit.hpp"

namespace strobe::sim {

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string spin_words(const std::string& spin) {
  if (spin == "zero") return "no spin";
  return spin == "top" ? "topspin" : "backspin";
}

std::string entry(const char* key, double value) { return fmt::format("{} = {:.8g}\n", key, value); }
std::string spread(const char* key, double sd) {
  return sd > 0.0 ? fmt::format("{} = {:.6g}\n", key, sd) : "";
}

std::string left_over(const FittedScene& fitted, const thesis::Condition& c) {
  return fmt::format(
      "# Left of the published lift-off, simulated less published: vx {:.3f} m/s ({:.2f} sd), "
      "spin {:.2f} rad/s ({:.2f} sd).\n",
      fitted.left_vx_mps, fitted.left_vx_mps / c.vx_lo_mps.sd, fitted.left_omega_radps,
      fitted.left_omega_radps / c.omega_lo_radps.sd);
}

std::string bounce(const BounceSettings& b) {
  std::string text = "\n[bounce]\ncontact = \"ode\"\n";
  text += entry("e", b.e) + entry("e_speed_mps", b.e_speed_mps) + spread("e_sd", b.e_sd);
  text += entry("mu", b.mu) + spread("mu_sd", b.mu_sd);
  text += entry("stiffness_ratio", b.stiffness_ratio) + spread("stiffness_ratio_sd", b.stiffness_ratio_sd);
  text += entry("damping_ratio", b.damping_ratio);
  text += entry("offset_share", b.offset_share) + spread("offset_share_sd", b.offset_share_sd);
  if (b.offset_share_sd > 0.0) text += entry("offset_grip_correlation", b.offset_grip_correlation);
  text += entry("dwell_ms", b.dwell_s * 1e3) + spread("dwell_sd_ms", b.dwell_sd_s * 1e3);
  return text;
}

}  // namespace

std::string to_toml(const FittedScene& fitted, const thesis::Condition& condition) {
  const MachineSettings& m = fitted.scene.machine;
  const TabletSettings& t = fitted.scene.tablet;
  std::string text = "# Written by `strobe-sim fit` from the thesis's tables; sim/fit/fit.hpp says how.\n";
  text += fitted.slides ? "# The ball slides throughout.\n" : "# The ball grips.\n";
  text += left_over(fitted, condition);
  for (const MissedSpread& miss : fitted.missed)
    text += fmt::format("# {}: published sd {:.3g}, here {:.3g}.\n", reduction::name(miss.quantity),
                        miss.published_sd, miss.expected_sd);
  text += fmt::format("title = \"{}, {:.2f} degrees\"\n", spin_words(condition.spin),
                      condition.theta_in_deg.mean);
  text += "\n[ball]\n" + fmt::format("alpha = {}\n", fitted.scene.ball.alpha);
  text += "\n[machine]\n";
  text += entry("speed_mps", m.speed_mps) + spread("speed_sd_mps", m.speed_sd_mps);
  text += entry("angle_deg", m.angle_rad * kDegrees) + spread("angle_sd_deg", m.angle_sd_rad * kDegrees);
  text += entry("spin_radps", m.spin_radps) + spread("spin_sd_radps", m.spin_sd_radps);
  text += bounce(fitted.scene.bounce);
  text += "\n[tablet]\n";
  text += fmt::format("centre_sd_mm = {:.6g}\nequator_sd_deg = {:.6g}\n", t.centre_sd_m * 1e3,
                      t.equator_sd_rad * kDegrees);
  return text;
}

}  // namespace strobe::sim
