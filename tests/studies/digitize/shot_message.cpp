#include "tests/studies/digitize/shot_message.hpp"

#include <fmt/format.h>

#include <cmath>

#include "common/messages/record.hpp"
#include "common/units/angles.hpp"

namespace strobe::studies::digitize {

namespace {

using strobe_msgs::flash_t;
using strobe_msgs::shot_t;

constexpr std::int64_t kBootId = 77;
constexpr std::int64_t kIssue_ns = 60;

std::int64_t nanoseconds_of(double s) { return std::llround(s * 1e9); }

flash_t flash_message(int index, std::int64_t edge_ns, std::int64_t first_ns,
                      const std::optional<double>& seen_s) {
  flash_t flash{};
  flash.lamps = 3;
  flash.flash_index = index;
  flash.commanded_ns = edge_ns;
  flash.issue_start_ns = edge_ns - kIssue_ns;
  flash.issue_end_ns = edge_ns + kIssue_ns;
  flash.observed_a_ns = flash.observed_b_ns =
      seen_s ? first_ns + nanoseconds_of(*seen_s) : std::int64_t{flash_t::NO_TIME};
  return flash;
}

}  // namespace

shot_t shot_message(const KnownPhotograph& known, const sim::Scene& scene, int shot_id,
                    std::int64_t closed_ns, Duration period) {
  const sim::Exposure& exposure = known.shot.exposure;
  const std::int64_t shift_ns = closed_ns - to_ns(exposure.closed);
  shot_t shot{};
  shot.schema_version = shot_t::SCHEMA_VERSION;
  shot.boot_id = kBootId;
  shot.shot_id = shot_id;
  shot.host_id = 1;
  shot.start_ns = to_ns(exposure.line_on) + shift_ns;
  shot.shutter_open_ns = to_ns(exposure.opened) + shift_ns;
  shot.shutter_close_ns = closed_ns;
  shot.trigger_ns = shot_t::NO_TIME;
  shot.gate_ns = shot_t::NO_TIME;
  shot.shutter_on_ns = shot.start_ns;
  shot.shutter_off_ns = shot_t::NO_TIME;
  shot.lamp_delay_a_us = shot.lamp_delay_b_us = scene.lamps.delay_s * 1e6;
  shot.sensor_a_fitted = shot.sensor_b_fitted = true;
  shot.late_tolerance_us = 100.0;
  const std::int64_t first_ns = to_ns(exposure.pulses.front().edge) + shift_ns;
  for (std::size_t i = 0; i < exposure.pulses.size(); ++i)
    shot.flashes.push_back(flash_message(static_cast<int>(i), to_ns(exposure.pulses[i].edge) + shift_ns,
                                         first_ns, known.scene_truth.flash_times_s[i]));
  shot.flash_count = static_cast<std::int32_t>(shot.flashes.size());
  shot.plan.period_ns = period.count();
  shot.plan.shutter_open_ns = shot.shutter_close_ns - shot.shutter_open_ns;
  shot.notes = messages::notes_from_record({{"temperature_c", fmt::format("{}", scene.air.temperature_c)}});
  shot.note_count = static_cast<std::int32_t>(shot.notes.size());
  return shot;
}

host::RigFile rig_of(const sim::Scene& scene, const Calibrated& calibrated,
                     const std::optional<std::array<double, 3>>& viewpoint_px) {
  host::RigFile rig;
  rig.rig = "bench";
  if (scene.kind) rig.ball = host::settings_of(*scene.kind);
  rig.ball.line = scene.ball_appearance.line;
  rig.ball.diameter_m = calibrated.ball_diameter_m;
  rig.ball.diameter_sd_m = calibrated.ball_diameter_sd_m;
  rig.ball.mass_kg = scene.ball.mass_kg;
  rig.ball.alpha = scene.ball.alpha;
  rig.analysis.surface_angle_deg = degrees(scene.surface_angle_rad);
  rig.camera.px_per_m = calibrated.px_per_m;
  rig.camera.px_per_m_sd = calibrated.px_per_m_sd;
  rig.camera.viewpoint_px = viewpoint_px;
  return rig;
}

}  // namespace strobe::studies::digitize
