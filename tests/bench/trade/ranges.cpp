#include "tests/bench/trade/ranges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string_view>

#include "tests/bench/trade/impact_scenes.hpp"

namespace strobe::bench::trade {

namespace {

struct Quantity {
  std::string_view name;
  double (*of)(const ImpactScene& s);
};

constexpr std::array kQuantities{
    Quantity{"v_td_mps", [](const ImpactScene& s) { return s.speed_mps(); }},
    Quantity{"theta_in_deg",
             [](const ImpactScene& s) {
               return std::atan2(-s.touchdown.vy_mps, s.touchdown.vx_mps) * 180.0 / std::numbers::pi;
             }},
    Quantity{"omega_radps", [](const ImpactScene& s) { return s.touchdown.omega_radps; }},
    Quantity{"spin_ratio",
             [](const ImpactScene& s) {
               return std::abs(s.ball.radius_m() * s.touchdown.omega_radps) / s.speed_mps();
             }},
    Quantity{"e", [](const ImpactScene& s) { return s.contact.e; }},
    Quantity{"mu", [](const ImpactScene& s) { return s.contact.mu; }},
    Quantity{"alpha", [](const ImpactScene& s) { return s.ball.alpha; }},
    Quantity{"diameter_m", [](const ImpactScene& s) { return s.ball.diameter_m; }},
    Quantity{"mass_kg", [](const ImpactScene& s) { return s.ball.mass_kg; }},
    Quantity{"dwell_time_ms", [](const ImpactScene& s) { return s.contact.dwell_s * 1e3; }},
    Quantity{"kt_ratio", [](const ImpactScene& s) { return s.contact.stiffness_ratio; }},
    Quantity{"ct", [](const ImpactScene& s) { return s.contact.damping_ratio; }},
    Quantity{"offset_footprint", [](const ImpactScene& s) { return s.contact.offset_share; }},
    Quantity{"offset_reference_mps", [](const ImpactScene& s) { return s.contact.offset_reference_mps; }},
    Quantity{"gravity_mps2", [](const ImpactScene& s) { return s.contact.gravity_mps2; }}};

}  // namespace

std::string ranges_text(const Effort& effort) {
  std::vector<ImpactScene> scenes = practical_impacts(effort.scenes, effort.seed);
  for (const ImpactScene& s : thesis_impacts()) scenes.push_back(s);
  std::string text = "study,quantity,lowest,highest\n";
  for (const Quantity& quantity : kQuantities) {
    const auto [lowest, highest] = std::ranges::minmax_element(scenes, {}, quantity.of);
    text += fmt::format("lift_off,{},{},{}\n", quantity.name, quantity.of(*lowest), quantity.of(*highest));
  }
  // Both noises measured by hand and finely, five images a leg: estimator_studies().
  text += "reduce,images_per_leg,5,5\nreduce_estimated,images_per_leg,5,5\nreduce_fine,images_per_leg,5,5\n";
  return text;
}

}  // namespace strobe::bench::trade
