#include "host/design/set_up.hpp"

#include <fmt/format.h>

#include <cmath>

#include "common/units/angles.hpp"
#include "host/assembly/flash_times.hpp"

namespace strobe::host {
namespace {

constexpr double kSurfaceAt = 1.0 / 9.0;
// Where the rig file does not say how much the machine's lag differs from shot to shot.
constexpr double kUsualArrivalSd_s = 0.003;
// Stamps by the kernel, of a photodiode: what shots of the simulated rig and of a bench show.
constexpr double kUsualStampSd_s = 0.5e-6;

}  // namespace

Result<SetUp> set_up_of(const RigFile& rig) {
  SetUp s;
  s.camera = rig.camera;
  const auto scale = rig.camera.px_per_m ? rig.camera.px_per_m : rig.analysis.px_per_m;
  if (!scale) return fail("camera.px_per_m: the rig file states no scale; --px-per-m gives one");
  s.px_per_m = *scale;
  if (!s.camera.px_per_m_sd && !rig.camera.px_per_m) s.camera.px_per_m_sd = rig.analysis.px_per_m_sd;
  s.size_assumed = !rig.camera.width_px || !rig.camera.height_px;
  s.width_px = s.size_assumed ? kUsualWidth_m * s.px_per_m : *rig.camera.width_px;
  s.height_px = s.size_assumed ? kUsualHeight_m * s.px_per_m : *rig.camera.height_px;
  s.touchdown_x_px = 0.5 * s.width_px;
  s.surface_y_px = kSurfaceAt * s.height_px;
  if (const auto& line = rig.camera.surface_px) s.surface_y_px = 0.5 * ((*line)[1] + (*line)[3]);
  s.surface_angle_rad = radians(rig.analysis.surface_angle_deg.value_or(0.0));
  s.ball_diameter_sd_m = rig.ball.diameter_sd_m;
  s.temperature_c = note_number(rig.record, "temperature_c");
  s.fastest_spin_radps = rig.ball.fastest_spin_radps;
  s.flash_time_sd_s = rig.analysis.flash_time_sd_s.value_or(kUsualStampSd_s);
  s.arrival_sd_s = rig.analysis.machine_lag_sd_s.value_or(kUsualArrivalSd_s);
  if (rig.analysis.gate_distance_m) s.gate_distance_m = *rig.analysis.gate_distance_m;
  s.gate_distance_sd_m = rig.analysis.gate_distance_sd_m;
  s.limits = rig.limits;
  s.match_tolerance_percent = rig.analysis.match_tolerance_percent;
  return s;
}

Result<SetUp> through(const SetUp& set_up, LensSetUp lens) {
  lens.width_px = static_cast<int>(std::lround(set_up.width_px));
  lens.height_px = static_cast<int>(std::lround(set_up.height_px));
  if (lens.focal_length_mm == 0.0) {
    LensSetUp any = lens;
    any.focal_length_mm = 1.0;
    if (auto known = check(any); !known) return tl::unexpected(known.error());
    const auto usual = focal_length_for_view_mm(any, {kUsualWidth_m, kUsualHeight_m});
    if (!usual)
      return fail(fmt::format("no usual lens sees {} x {} m from there", kUsualWidth_m, kUsualHeight_m));
    lens.focal_length_mm = *usual;
  }
  if (auto known = check(lens); !known) return tl::unexpected(known.error());
  SetUp s = with_lens(set_up, px_per_m(lens) / set_up.px_per_m);
  s.lens = lens;
  return s;
}

SetUp with_lens(SetUp s, double factor) {
  s.px_per_m *= factor;
  if (s.camera.px_per_m) *s.camera.px_per_m *= factor;
  if (s.camera.px_per_m_sd) *s.camera.px_per_m_sd *= factor;
  s.camera.map.reset();  // of the former lens
  s.camera.map_errors.clear();
  s.lens.reset();
  return s;
}

}  // namespace strobe::host
