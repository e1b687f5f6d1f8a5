#include "host/assembly/drop_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/flight/aerodynamics.hpp"
#include "common/flight/vertical.hpp"
#include "host/config/notes.hpp"

namespace strobe::host {
namespace {

// Steps in diameters (strobe-bench drops): what is chosen; less hides images.
constexpr double kUsualStep = 1.5;
constexpr double kMinStep = 0.6;
// Images of the way down: as many as are wanted, and so few that nothing is left by which a wrong one shows.
constexpr int kWanted = 6;
constexpr int kMinImages = 4;
// Of the speed at the surface: slower, images of one leg hide each other.
constexpr double kSlowestShare = 0.4;
// Of the rebound, where it is not known.
constexpr double kUsualRestitution = 0.75;

Duration duration_of(double seconds) { return microseconds{std::llround(1e6 * seconds)}; }

struct Fall {
  double speed_mps = 0.0;
  double lit_s = 0.0;  ///< before touchdown, while it is in view and fast enough
};

Fall fall_of(const PlanFile& plan, const RigFile& rig) {
  const double density = flight::air_density_kgpm3(note_number(rig.record, "temperature_c").value_or(20.0));
  const double drag = flight::aerodynamics(rig.ball.ball(), density, {}, rig.ball.air_law()).drag_per_m;
  Fall fall{flight::fall_speed_mps(plan.drop_height_m, drag).value, 0.0};
  double height_m = plan.drop_height_m - flight::fall_m(kSlowestShare * fall.speed_mps, drag).value;
  const auto px_per_m = rig.camera.px_per_m ? rig.camera.px_per_m : rig.analysis.px_per_m;
  if (px_per_m && rig.camera.height_px) {
    // Centres up to a radius below the photograph's upper edge.
    const double surface_px = rig.camera.surface_px
                                  ? 0.5 * ((*rig.camera.surface_px)[1] + (*rig.camera.surface_px)[3])
                                  : 0.1 * *rig.camera.height_px;
    const double view_m = (*rig.camera.height_px - surface_px) / *px_per_m - rig.ball.diameter_m;
    height_m = std::min(height_m, view_m);
  }
  if (!(height_m > 0.0)) return fall;
  const double upper_mps = flight::fall_speed_mps(plan.drop_height_m - height_m, drag).value;
  fall.lit_s = 2.0 * height_m / (upper_mps + fall.speed_mps);
  return fall;
}

}  // namespace

Result<PlanFile> drop_plan(const PlanFile& plan, const RigFile& rig) {
  const Fall fall = fall_of(plan, rig);
  const double of_diameter_s = rig.ball.diameter_m / fall.speed_mps;
  const double lamp_s =
      to_seconds(std::max(rig.limits.lamp_period, rig.limits.flash_interval + microseconds{1}));
  const double longest_s = fall.lit_s / kMinImages;
  const double chosen_s = std::max(
      std::clamp(fall.lit_s / kWanted, kMinStep * of_diameter_s, kUsualStep * of_diameter_s), lamp_s);
  if (chosen_s > longest_s)
    return fail(fmt::format(
        "drop_height_m: a ball of {:.0f} mm is in view for the last {:.0f} ms of a fall from {:g} m, too "
        "short "
        "for {} images that do not hide each other: show more of its fall, or drop it from higher",
        1e3 * rig.ball.diameter_m, 1e3 * fall.lit_s, plan.drop_height_m, kMinImages));
  PlanFile result = plan;
  if (!plan.period_stated) {
    result.even.period = microseconds{std::llround(1e4 * chosen_s) * 100};
    result.intervals.clear();
    result.period_stated = true;
  }
  const double stated_s = to_seconds(result.even.period);
  if (stated_s < kMinStep * of_diameter_s || stated_s > 1.05 * longest_s)
    return fail(fmt::format(
        "period_us: {:.1f} ms between flashes {} where a ball of {:.0f} mm drops from {:g} m and lands with "
        "{:.1f} m/s: {:.1f} ms would do, which is taken where period_us is left out",
        1e3 * stated_s, stated_s > longest_s ? "leave too few images" : "let images hide each other",
        1e3 * rig.ball.diameter_m, plan.drop_height_m, fall.speed_mps, 1e3 * chosen_s));
  if (result.even.train == Train::gated) return result;
  const double g = flight::kStandardGravity_mps2;
  const Duration before = duration_of((1.0 - kSlowestShare) * fall.speed_mps / g);
  const Duration after = duration_of((1.0 - kSlowestShare) * kUsualRestitution * fall.speed_mps / g);
  Duration& impact_at = result.even.impact_at;
  if (impact_at == Duration{}) impact_at = rig.limits.impact_at;
  if (impact_at == Duration{}) impact_at = result.even.exposure / 2;
  const Duration rest = result.even.exposure - impact_at;
  impact_at = std::min(impact_at, before);
  result.even.exposure = impact_at + std::min(rest, after);
  return result;
}

}  // namespace strobe::host
