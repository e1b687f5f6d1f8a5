#include "host/commission/light_step.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "host/commission/guard_band.hpp"
#include "host/commission/shot_step.hpp"
#include "host/commission/steps.hpp"

namespace strobe::commission {
namespace {

/// Over the dark: eight steps of an 8-bit file, so that rounding averages out.
constexpr float kLit = 0.03F;
/// Of the pixels: 5,000 of 5 million, whose noise is then below a thousandth.
constexpr double kMinShare = 0.001;

/// Of a short train's light over the other one's: less is not chance, and whether light adds up is left open.
constexpr double kWhole = 0.85;

/// Over the pixels that are lit in the photograph of both lamps and saturated in none; nothing where there
/// are none.
struct Means {
  double share = 0.0;             ///< of those pixels
  std::array<double, 5> light{};  ///< in the order of LampPhotographs
};

Means means_of(const LampPhotographs& p) {
  const std::array<const digitize::Photograph*, 5> all{
      &p.of_a.photograph, &p.of_b.photograph, &p.of_both.photograph, &p.early.photograph, &p.late.photograph};
  Means means;
  std::size_t pixels = 0;
  const int rows = all[0]->height(), columns = all[0]->width();
  for (int row = 0; row < rows; ++row) {
    std::array<const float*, 5> line{};
    for (std::size_t k = 0; k < all.size(); ++k) line[k] = all[k]->intensity.ptr<float>(row);
    for (int column = 0; column < columns; ++column) {
      const auto value = [&](std::size_t k) { return line[k][column]; };
      if (value(2) - std::min(value(3), value(4)) < kLit) continue;
      bool clipped = false;
      for (std::size_t k = 0; k < all.size(); ++k) clipped = clipped || value(k) >= all[k]->saturation;
      if (clipped) continue;
      for (std::size_t k = 0; k < all.size(); ++k) means.light[k] += static_cast<double>(value(k));
      ++pixels;
    }
  }
  means.share = static_cast<double>(pixels) / (static_cast<double>(rows) * columns);
  for (double& light : means.light) light /= static_cast<double>(std::max<std::size_t>(pixels, 1));
  return means;
}

/// Of the other lamp's light: none.
constexpr double kNoLight = 0.05;

/// Light of a hundred flashes that vary by 5 % is known to 0.5 %; sixteen at either end of the exposure.
constexpr int kFlashes = 100, kFlashesAtEnds = 16;
constexpr double kFlashSd = 0.05;
/// As shares: of a lamp's light over the other's; of light that does not add up, and of one end's over the
/// other's, where each flash is two lamps'.
const double kRatioSd = kFlashSd * std::sqrt(2.0 / kFlashes), kExcessSd = kFlashSd / std::sqrt(kFlashes),
             kEndsSd = kFlashSd / std::sqrt(kFlashesAtEnds);
/// Of the exposure, left dark at either end: the shutter's lag varies.
constexpr int kMargin = 50;

constexpr const char* kAgain = "do the step again";

enum class Where { middle, beginning, end };

/// So many flashes in an exposure as long as the rig's plan has.
ShotPlan train(const host::RigFile& rig, Lamps lamps, int flashes, Where where) {
  ShotPlan plan;
  plan.dry = true;
  plan.period = std::max(rig.plan.even.period, rig.limits.lamp_period);
  plan.exposure = std::min(rig.plan.even.exposure, rig.limits.longest_exposure);
  plan.impact_at = plan.exposure / 2;
  const Duration margin = plan.exposure / kMargin;
  const auto room = static_cast<int>((plan.exposure - 2 * margin) / plan.period);
  const int count = std::max(1, std::min({flashes, room, rig.limits.max_flashes}));
  const Duration length = plan.period * (count - 1);
  Duration first = margin;
  if (where == Where::middle) first = (plan.exposure - length) / 2;
  if (where == Where::end) first = plan.exposure - margin - length;
  for (int k = 0; k < count; ++k) plan.code.push_back({first + plan.period * k, lamps});
  return plan;
}

Fire request(const host::RigFile& rig, Lamps lamps, int flashes, Where where, const char* words) {
  Fire fire;
  fire.plan = train(rig, lamps, flashes, where);
  fire.words = words;
  fire.photograph = true;
  return fire;
}

class LightStep final : public ShotStep {
 public:
  LightStep()
      : ShotStep(
            {{"light", "the lamps' light on the photograph", {"lamps", "camera"}},
             {"exposure_window", "the shutter open from first to last flash", {"shutter", "camera", "plan"}}},
            {.outputs = true, .photographs = true}, {.missing = 1}) {}
  std::string briefing(const host::RigFile&) const override {
    return "FLASHES, five times, each with a photograph: lamp A, lamp B, both, and both at the beginning and "
           "the end of the exposure; the machine's trigger stays still. Room dark, plate in the view. Key "
           "on, e-stop released.";
  }

 private:
  std::vector<Fire> shots(const host::RigFile& rig) const override {
    return {request(rig, Lamps::a, kFlashes, Where::middle, "lamp A, with a photograph"),
            request(rig, Lamps::b, kFlashes, Where::middle, "lamp B, with a photograph"),
            request(rig, Lamps::both, kFlashes, Where::middle, "both lamps, with a photograph"),
            request(rig, Lamps::both, kFlashesAtEnds, Where::beginning,
                    "both lamps, at the exposure's beginning"),
            request(rig, Lamps::both, kFlashesAtEnds, Where::end, "both lamps, at the exposure's end")};
  }

  std::vector<StepResult> judge(const std::vector<SoundShot>& shots, const host::RigFile& rig) override {
    std::array<LitPhotograph, 5> photographs;
    for (std::size_t k = 0; k < photographs.size(); ++k) {
      const host::Shot& shot = shots[k].fired;
      auto read = digitize::load_photograph(*shot.photograph);
      if (!read)
        return {failed("unreadable", read.error().message, "let the camera write TIFF, PNG or JPEG, whole"),
                skipped("a photograph could not be read")};
      photographs[k] = {std::move(*read), static_cast<int>(shot.summary->flashes.size())};
    }
    const auto light =
        measure_lamp_light({photographs[0], photographs[1], photographs[2], photographs[3], photographs[4]});
    if (!light)
      return {failed("nothing_lit", light.error().message,
                     "then run the step again: strobe commission --only light"),
              skipped("nothing in the view is lit")};
    return {judge_light(*light, rig.commission), judge_exposure_window(*light)};
  }
};

}  // namespace

Result<LampLight> measure_lamp_light(const LampPhotographs& p) {
  for (const LitPhotograph* other : {&p.of_b, &p.of_both, &p.early, &p.late}) {
    if (other->photograph.intensity.size() != p.of_a.photograph.intensity.size())
      return fail("the photographs differ in size");
  }
  const Means means = means_of(p);
  const auto& [mean_a, mean_b, mean_both, mean_early, mean_late] = means.light;
  LampLight light;
  light.lit_share = means.share;
  if (means.share < kMinShare)
    return fail(
        "hardly anything in the view is lit by the lamps: stand a white sheet of paper where balls fly");
  // A, B and both flash at the same instants: however much of the exposure is cut off, this is the dark.
  const double dark = mean_a + mean_b - mean_both;
  const double of_early = (mean_early - dark) / p.early.flashes,
               of_late = (mean_late - dark) / p.late.flashes;
  const double whole = std::max(of_early, of_late);
  light.early = whole > 0.0 ? of_early / whole : 1.0;
  light.late = whole > 0.0 ? of_late / whole : 1.0;
  light.dark = dark;
  light.a = (mean_a - dark) / p.of_a.flashes, light.b = (mean_b - dark) / p.of_b.flashes;
  if (std::min(light.early, light.late) < kWhole) return light;
  // Of A, of B and of the short trains: three equations for a, b and the dark, of which both make a fourth.
  const double flashes_of_short = 0.5 * (p.early.flashes + p.late.flashes);
  Eigen::Matrix3d flashes;
  flashes << p.of_a.flashes, 0.0, 1.0, 0.0, p.of_b.flashes, 1.0, flashes_of_short, flashes_of_short, 1.0;
  const Eigen::Vector3d solved =
      flashes.partialPivLu().solve(Eigen::Vector3d(mean_a, mean_b, 0.5 * (mean_early + mean_late)));
  light.a = solved[0], light.b = solved[1], light.dark = solved[2];
  const double of_both = mean_both - light.dark;
  light.excess = of_both > 0.0 ? 1.0 - p.of_both.flashes * (light.a + light.b) / of_both : 0.0;
  return light;
}

StepResult judge_light(const LampLight& light, const host::CommissionTable& limits) {
  const double bright = std::max(light.a, light.b), dim = std::max(0.0, std::min(light.a, light.b));
  const bool a_is_dim = light.a < light.b;
  const char letter = a_is_dim ? 'A' : 'B';
  StepResult result =
      passed(light.a > 0.0 && light.b > 0.0 ? light.a / light.b : 0.0, {}, "",
             fmt::format("A over B from {:.2f} to {:.2f}, both together within {:.0f} % of their sum",
                         1.0 / limits.brightness_ratio, limits.brightness_ratio, 100.0 * kMaxExcess));
  result.figures = {{"light_a", light.a, {}, {}, 0},
                    {"light_b", light.b, {}, {}, 0},
                    {"dark", light.dark, {}, {}, 0},
                    {"excess", light.excess, {}, 0.0, 0},
                    {"lit_share", light.lit_share, {}, {}, 0}};
  result.words = fmt::format(
      "lamp A lights the photograph {:.2f} times as brightly as lamp B; both together {:+.1f} % against the "
      "sum",
      *result.value, 100.0 * light.excess);
  if (bright <= 0.0) {
    result.words = "neither lamp lights the photograph";
    mark_failed(result, "no_light", "is the lens uncovered, and is the shutter open while the lamps flash?");
  } else if (dim < kNoLight * bright) {
    result.words = fmt::format("lamp {} gives no light on the photograph", letter);
    mark_failed(
        result, a_is_dim ? "lamp_a_unlit" : "lamp_b_unlit",
        fmt::format(
            "is lamp {} turned to the plane of the balls, and does its sensor see it and not another light?",
            letter));
  } else {
    hold(result, interval(*result.value, *result.value * kRatioSd),
         {1.0 / limits.brightness_ratio, limits.brightness_ratio}, a_is_dim ? "lamp_a_dim" : "lamp_b_dim",
         fmt::format("clean lamp {}, bring it nearer or turn it; look at its discharge energy", letter),
         kAgain);
    hold(result, interval(light.excess, kExcessSd), within(kMaxExcess), "light_does_not_add_up",
         "numbers are not proportional to light (firmware/BENCH.md, section 4), or lamps that flash together "
         "weaken each "
         "other",
         kAgain);
  }
  return result;
}

StepResult judge_exposure_window(const LampLight& light) {
  StepResult result =
      passed(100.0 * std::min(light.early, light.late), {}, "%",
             fmt::format("at least {:.0f} % of the light of the first and of the last flashes",
                         100.0 * kMinEdgeLight));
  result.figures = {{"early_percent", 100.0 * light.early, {}, 100.0, 0},
                    {"late_percent", 100.0 * light.late, {}, 100.0, 0}};
  result.words =
      fmt::format("the photograph has {:.0f} % of the first flashes' light and {:.0f} % of the last ones'",
                  100.0 * light.early, 100.0 * light.late);
  hold(result, interval(light.early, kEndsSd), {.least = kMinEdgeLight}, "shutter_opens_late",
       "the shutter opens after the first flashes: measure its lag, and enter lag_ms in [shutter]", kAgain);
  hold(
      result, interval(light.late, kEndsSd), {.least = kMinEdgeLight}, "shutter_closes_early",
      "the shutter closes before the last flashes: set the camera to bulb, and its own exposure time to none",
      kAgain);
  return result;
}

std::unique_ptr<Step> light_step() { return std::make_unique<LightStep>(); }

}  // namespace strobe::commission
