#include "host/commission/camera/light_judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace strobe::commission {
namespace {

/// Of the other lamp's light: none.
constexpr double kNoLight = 0.05;

}  // namespace

StepResult judge_light(const std::string& id, const LampLight& light, const host::CommissionTable& limits) {
  const double bright = std::max(light.a, light.b), dim = std::max(0.0, std::min(light.a, light.b));
  const bool a_is_dim = light.a < light.b;
  const char letter = a_is_dim ? 'A' : 'B';
  StepResult result;
  result.id = id;
  result.value = light.a > 0.0 && light.b > 0.0 ? light.a / light.b : 0.0;
  result.limit = fmt::format("A over B within {:.2f} to {:.2f}, their light adds up to {:.0f} %",
                             1.0 / limits.brightness_ratio, limits.brightness_ratio, 100.0 * kMaxExcess);
  result.figures = {{"light_a", light.a, {}, {}, 0},
                    {"light_b", light.b, {}, {}, 0},
                    {"dark", light.dark, {}, {}, 0},
                    {"excess", light.excess, {}, 0.0, 0},
                    {"lit_share", light.lit_share, {}, {}, 0}};
  result.words = fmt::format(
      "lamp A lights the picture {:.2f} times as brightly as lamp B; both together {:+.1f} % against the sum",
      *result.value, 100.0 * light.excess);
  result.state = StepState::passed;
  if (bright <= 0.0) {
    result.words = "neither lamp lights the picture";
    mark_failed(result, "no_light", "is the lens uncovered, and is the shutter open while the lamps flash?");
  } else if (dim < kNoLight * bright) {
    result.words = fmt::format("lamp {} gives no light on the picture", letter);
    mark_failed(
        result, a_is_dim ? "lamp_a_unlit" : "lamp_b_unlit",
        fmt::format(
            "is lamp {} turned to the plane of the balls, and does its sensor see it and not another light?",
            letter));
  } else if (bright > limits.brightness_ratio * dim) {
    mark_failed(
        result, a_is_dim ? "lamp_a_dim" : "lamp_b_dim",
        fmt::format("clean lamp {}, bring it nearer or turn it; look at its discharge energy", letter));
  } else if (std::abs(light.excess) > kMaxExcess) {
    mark_failed(
        result, "light_does_not_add_up",
        "numbers are not proportional to light (bench, section 4), or lamps that flash together weaken "
        "each other");
  }
  return result;
}

StepResult judge_exposure_window(const std::string& id, const LampLight& light) {
  StepResult result;
  result.id = id;
  result.value = 100.0 * std::min(light.early, light.late);
  result.unit = "%";
  result.limit = fmt::format("at least {:.0f} % of the light of the first and of the last flashes",
                             100.0 * kMinEdgeLight);
  result.figures = {{"early_percent", 100.0 * light.early, {}, 100.0, 0},
                    {"late_percent", 100.0 * light.late, {}, 100.0, 0}};
  result.words =
      fmt::format("the picture has {:.0f} % of the first flashes' light and {:.0f} % of the last ones'",
                  100.0 * light.early, 100.0 * light.late);
  result.state = StepState::passed;
  if (light.early < kMinEdgeLight)
    mark_failed(result, "shutter_opens_late",
                "the shutter opens after the first flashes: measure its lag, and enter lag_ms in [shutter]");
  else if (light.late < kMinEdgeLight)
    mark_failed(
        result, "shutter_closes_early",
        "the shutter closes before the last flashes: set the camera to bulb, and its own exposure time "
        "to none");
  return result;
}

}  // namespace strobe::commission
