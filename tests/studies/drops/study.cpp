#include "tests/studies/drops/study.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "common/flight/aerodynamics.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/units/angles.hpp"
#include "host/assembly/assemble.hpp"
#include "host/assembly/coded_spacing.hpp"
#include "host/photographs/measure_photograph.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/motion/flight.hpp"
#include "sim/random/draws.hpp"
#include "tests/studies/digitize/photographs.hpp"
#include "tests/studies/digitize/shot_message.hpp"

namespace strobe::studies::drops {
namespace {

using digitize::KnownPhotograph;
using reduction::Flag;
using reduction::Quantity;

struct DroppedBall {
  const char* name;
  ball::Ball ball;
  double e, dwell_s;
  double px_per_m, view_m;  ///< of the camera that a lab would put up for it
};
// Sizes and masses by the ITF's, FIBA's and ITTF's rules.
const std::array<DroppedBall, kBallCount> kBalls{
    {{"tennis", {0.067, 0.0577, 0.55}, 0.77, 0.0052, 1500.0, 0.9},
     {"basketball", {0.242, 0.610, 0.62}, 0.82, 0.0150, 700.0, 1.3},
     {"table_tennis", {0.040, 0.0027, 0.66}, 0.90, 0.0012, 2500.0, 0.45}}};
constexpr std::array<double, kHeightCount> kHeights_m{0.3, 1.0, 1.8, 2.0, 2.54};

constexpr double kScaleShareSd = 5e-4, kSurfaceSd_px = 0.3;

/// What all know of drops, and what differs from shot to shot.
Result<sim::Scene> scene_of(const DropCase& c, const DropOptions& options) {
  auto scene = sim::load_scene("drop_100in");
  if (!scene) return scene;
  const DroppedBall& b = kBalls[static_cast<std::size_t>(c.ball)];
  const double height_m = kHeights_m[static_cast<std::size_t>(c.height)];
  sim::Draws draws(options.seed + 1000003, sim::Purpose::tablet, static_cast<std::uint64_t>(c.shot));
  scene->name = name_of(c);
  scene->ball = b.ball;
  const flight::AirLaw air;
  scene->air.drag_coefficient = air.drag_coefficient + air.drag_coefficient_sd * draws.normal();
  const sim::VerticalFlight fall = sim::falling(*scene, height_m);
  scene->machine.drop_height_m = height_m;
  scene->machine.speed_mps = fall.speed_mps;
  scene->machine.lag_s = fall.time_s;
  scene->bounce.e = b.e;
  scene->bounce.e_sd = 0.02;
  scene->bounce.e_speed_mps = fall.speed_mps;
  scene->bounce.dwell_s = b.dwell_s;
  sim::CameraSettings& camera = scene->camera;
  camera.px_per_m = b.px_per_m;
  camera.half_width_m = 0.02 + 0.5 * b.ball.diameter_m;
  camera.height_m = b.view_m;
  camera.origin_x_px = (camera.half_width_m + 0.05) * b.px_per_m;
  camera.origin_y_px = 0.05 * b.px_per_m + 40.0;
  scene->photograph.exposure = 0.5;
  return scene;
}

/// Calibrated to sds, and off by as much; the surface's line, too.
host::RigFile rig_of(const sim::Scene& scene, const KnownPhotograph& known, const DropCase& c,
                     std::uint64_t seed) {
  sim::Draws draws(seed + 2000003, sim::Purpose::tablet, static_cast<std::uint64_t>(c.shot));
  const double px_per_m = known.scene_truth.px_per_m_of_ball;
  host::RigFile rig = digitize::rig_of(scene, {px_per_m * (1.0 + kScaleShareSd * draws.normal()),
                                               px_per_m * kScaleShareSd, scene.ball.diameter_m, 0.0});
  rig.camera.height_px = known.scene_truth.height_px;
  rig.camera.width_px = known.scene_truth.width_px;
  const auto& line = known.surface_px;
  rig.camera.surface_px = {line[0].x, line[0].y + kSurfaceSd_px * draws.normal(), line[1].x,
                           line[1].y + kSurfaceSd_px * draws.normal()};
  rig.camera.surface_sd_px = kSurfaceSd_px;
  return rig;
}

/// By the simulator's own flight.
double risen_m(const sim::Scene& scene, double vy_mps) {
  sim::Scene level = scene;
  level.surface_angle_rad = 0.0;
  const sim::Flight flight(level, {.vy_mps = vy_mps}, 0.0);
  double rises_s = 0.0, falls_s = vy_mps / 9.0;
  for (int round = 0; round < 50; ++round) {
    const double middle_s = 0.5 * (rises_s + falls_s);
    (flight.at(middle_s).vy_mps > 0.0 ? rises_s : falls_s) = middle_s;
  }
  return flight.at(rises_s).y_m;
}

double total(double a, double b) { return std::hypot(a, b); }

/// Flags that every such photograph has (nobody draws four points of a surface, few drops show a contact), or that
/// concern spin alone, say nothing of e.
bool tells_of_doubt(const reduction::FlagSet& flags) {
  for (const Flag flag : {Flag::flash_match_ambiguous, Flag::outlier_image, Flag::too_few_images,
                          Flag::residuals_exceed_noise, Flag::surface_suspect, Flag::degenerate_geometry,
                          Flag::scale_contradicts_ball})
    if (flags.has(flag)) return true;
  return false;
}

ReadDrop judged(const host::ShotReadout& result, const sim::Scene& scene, const reduction::Quantities& truth) {
  ReadDrop read;
  const reduction::Readout& r = result.readout;
  if (r.value[Quantity::e] && truth[Quantity::e]) {
    read.e_error = *r.value[Quantity::e] - *truth[Quantity::e];
    read.e_sd = total(r.sd[Quantity::e].value_or(0.0), r.sd_systematic[Quantity::e].value_or(0.0));
  }
  if (r.drop && truth[Quantity::vy_lo_mps]) {
    const reduction::DerivedNumber& height = r.drop->rebound_height_m;
    read.height_error_m = height.value - risen_m(scene, *truth[Quantity::vy_lo_mps]);
    read.height_sd_m = total(height.sd, height.sd_systematic);
  }
  read.flagged = tells_of_doubt(r.flags);
  for (std::size_t f = 0; f < reduction::kFlagCount; ++f)
    if (r.flags.has(static_cast<Flag>(f))) read.words += std::string(reduction::kFlagNames[f]) + " ";
  read.words += result.problem;
  return read;
}

std::vector<Duration> train_of(const ShotPlan& plan) {
  std::vector<Duration> train;
  for (const CodedFlash& flash : plan.code) train.push_back(flash.offset);
  if (plan.code.empty())
    for (Duration at{}; at < plan.exposure; at += plan.period) train.push_back(at);
  return train;
}

}  // namespace

DropCase drop_case(int i) { return {i % kBallCount, i / kBallCount % kHeightCount, i + 1}; }

std::string name_of(const DropCase& c) {
  return fmt::format("{}_{:g}m", kBalls[static_cast<std::size_t>(c.ball)].name,
                     kHeights_m[static_cast<std::size_t>(c.height)]);
}

Result<ReadDrop> read_drop(const DropCase& c, const DropOptions& options) {
  const auto scene = scene_of(c, options);
  if (!scene) return tl::unexpected(scene.error());
  digitize::Take take{.scene = *scene, .seed = options.seed, .shot = c.shot};
  auto exposure = digitize::known_exposure(take);
  if (!exposure) return tl::unexpected(exposure.error());
  const host::RigFile rig = rig_of(*scene, *exposure, c, options.seed);
  host::PlanFile plan;
  plan.drop_height_m = scene->machine.drop_height_m;
  plan.spacing = options.spacing;
  if (options.period_ms) {
    plan.even.period = microseconds{std::llround(1e3 * *options.period_ms)};
    plan.period_stated = true;
  }
  const host::SpacedPlan spaced = host::spaced_plan(plan, rig, true);
  ReadDrop read;
  read.refused = spaced.problem;
  if (!read.refused.empty()) return read;
  take.shooting.train = train_of(spaced.plan.shot());
  const auto known = digitize::known_photograph(take);
  if (!known) return tl::unexpected(known.error());
  const strobe_msgs::shot_t shot =
      digitize::shot_message(*known, *scene, c.shot, to_ns(known->shot.exposure.closed));
  auto settings = host::digitize_settings(rig, known->photograph.width(), known->photograph.height());
  if (!settings) return tl::unexpected(settings.error());
  settings->flash_times_s = host::flash_times_s(shot);
  const auto digitized = strobe::digitize::digitize(known->photograph, *settings);
  if (!digitized) return tl::unexpected(digitized.error());
  const strobe_msgs::frame_t frame = messages::frame_to_lcm(digitized->frame);
  read = judged(host::shot_readout(shot, frame, host::assembly_settings(rig)), *scene, known->shot.truth);
  read.period_ms = 1e3 * to_seconds(spaced.plan.even.period);
  read.images = static_cast<int>(frame.images.size());
  for (const std::string& remark : digitized->remarks) read.words += "; " + remark;
  return read;
}

}  // namespace strobe::studies::drops
