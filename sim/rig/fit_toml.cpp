#include <fmt/format.h>

#include "sim/rig/fit.hpp"

namespace strobe::sim {

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string spin_words(const std::string& spin) {
  if (spin == "zero") return "no spin";
  return spin == "top" ? "topspin" : "backspin";
}

std::string entry(const char* key, double value) { return fmt::format("{} = {:.6g}\n", key, value); }

}  // namespace

std::string to_toml(const FittedScene& fitted, const thesis::Condition& condition) {
  const MachineSettings& m = fitted.scene.machine;
  const BounceSettings& b = fitted.scene.bounce;
  const TabletSettings& t = fitted.scene.tablet;
  std::string text = "# Written by `strobe-sim fit` from the thesis's tables; sim/rig/fit.hpp says how.\n";
  text += fitted.slides ? "# The ball slides throughout.\n" : "# The ball grips.\n";
  for (const Excess& excess : fitted.excesses)
    text += fmt::format("# {}: published sd {:.3g}; tablet and machine alone make it {:.3g}.\n",
                        reduction::name(excess.quantity), excess.published_sd, excess.expected_sd);
  text += fmt::format("title = \"{}, {:.2f} degrees\"\n", spin_words(condition.spin),
                      condition.theta_in_deg.mean);
  text += "\n[machine]\n";
  text += entry("speed_mps", m.speed_mps) + entry("speed_sd_mps", m.speed_sd_mps);
  text += entry("angle_deg", m.angle_rad * kDegrees) + entry("angle_sd_deg", m.angle_sd_rad * kDegrees);
  text += entry("spin_radps", m.spin_radps) + entry("spin_sd_radps", m.spin_sd_radps);
  text += "\n[bounce]\ncontact = \"grip\"\n";
  text += entry("e", b.e) + entry("e_speed_mps", b.e_speed_mps) + entry("e_sd", b.e_sd);
  text += entry("mu", b.mu) + (b.mu_sd > 0.0 ? entry("mu_sd", b.mu_sd) : "");
  text += entry("ex", b.ex) + (b.ex_sd > 0.0 ? entry("ex_sd", b.ex_sd) : "");
  text += entry("offset_mm", b.offset_m * 1e3) + entry("offset_sd_mm", b.offset_sd_m * 1e3);
  text += entry("offset_grip_correlation", b.offset_grip_correlation);
  text += entry("dwell_ms", b.dwell_s * 1e3) + entry("dwell_sd_ms", b.dwell_sd_s * 1e3);
  text += "\n[tablet]\n";
  text += entry("centre_sd_mm", t.centre_sd_m * 1e3) + entry("equator_sd_deg", t.equator_sd_rad * kDegrees);
  return text;
}

}  // namespace strobe::sim
