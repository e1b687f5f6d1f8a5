#include "tests/studies/design/noise_photographs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/units/angles.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/photograph/appearance.hpp"
#include "sim/random/draws.hpp"

namespace strobe::studies::design {

namespace {

using digitize::KnownPhotograph;
using digitize::Take;
using digitize::TrueImage;
using sim::Draws;

constexpr double kBall_m = 0.066;
constexpr double kMaxRenderedPixels = 2e6;
/// Of this file's draws among those of the simulator.
constexpr std::uint64_t kStream = 0x6e6f697365ULL;

double between(Draws& draws, double least, double most) { return least + (most - least) * draws.uniform(); }
double scaled(Draws& draws, double least, double most) {
  return least * std::pow(most / least, draws.uniform());
}

/// Half width and height of a view that holds so many images of a leg. [m]
std::array<double, 2> view_of(const NoiseCondition& c, int images) {
  const double leg_m = (images - 0.5) * c.step * kBall_m;
  return {leg_m * std::cos(c.angle_rad) + 0.2 * kBall_m, leg_m * std::sin(c.angle_rad) + kBall_m};
}

double pixels_of(const NoiseCondition& c, int images) {
  const auto [half_width_m, height_m] = view_of(c, images);
  const double px_per_m = c.diameter_px / kBall_m;
  return px_per_m * px_per_m * (2.0 * half_width_m + 0.09) * (height_m + 0.065);
}

}  // namespace

NoiseCondition draw_condition(std::uint64_t seed, int number) {
  Draws draws(seed ^ kStream, sim::Purpose::appearance, static_cast<std::uint64_t>(number));
  NoiseCondition c;
  c.diameter_px = scaled(draws, 40.0, 450.0);
  c.blur_px = scaled(draws, 0.4, 3.0);
  c.motion_px = std::max(0.0, between(draws, -0.75, 3.0));
  c.exposure = scaled(draws, 0.125, 2.0);
  c.full_well_e = scaled(draws, 3000.0, 60000.0);
  c.read_noise_e = scaled(draws, 3.0, 30.0);
  c.bits = draws.uniform() < 0.5 ? 8 : 12;
  c.line_contrast = between(draws, 0.2, 1.0);
  do {
    c.period_s = scaled(draws, 0.7e-3, 8e-3);
    c.speed_mps = scaled(draws, 3.0, 45.0);
    c.step = c.period_s * c.speed_mps / kBall_m;
  } while (c.step < 0.25 || c.step > 1.4);
  c.angle_rad = radians(between(draws, 12.0, 75.0));
  c.spin_radps = between(draws, -300.0, 300.0);
  c.images = 4 + static_cast<int>(3.0 * draws.uniform());
  while (c.images > 3 && pixels_of(c, c.images) > kMaxRenderedPixels) --c.images;
  return c;
}

namespace {

Result<Take> take_of(const NoiseCondition& c, std::uint64_t seed, int number) {
  auto scene = sim::load_scene("zero_34");
  if (!scene) return tl::unexpected(scene.error());
  Take take{std::move(*scene), seed, number};
  sim::Scene& s = take.scene;
  s.ball.diameter_m = kBall_m;
  s.machine = {.speed_mps = c.speed_mps, .angle_rad = -c.angle_rad, .spin_radps = c.spin_radps};
  s.bounce.e_speed_mps = c.speed_mps * std::sin(c.angle_rad);
  s.bounce.e_slope_spm = 0.0;
  s.lamps.recharge_s = 50e-6;
  const double px_per_m = c.diameter_px / kBall_m;
  s.lamps.flash_s = std::max(1e-9, c.motion_px / (c.speed_mps * px_per_m));
  const auto [half_width_m, height_m] = view_of(c, c.images);
  s.camera.px_per_m = px_per_m;
  s.camera.half_width_m = half_width_m;
  s.camera.height_m = height_m;
  s.camera.origin_x_px = px_per_m * (half_width_m + 0.045);
  s.camera.origin_y_px = px_per_m * 0.03;
  s.photograph.exposure = c.exposure;
  s.photograph.full_well_e = c.full_well_e;
  s.photograph.read_noise_e = c.read_noise_e;
  s.photograph.bits = c.bits;
  s.photograph.blur_px = c.blur_px;
  s.ball_appearance.line_contrast = c.line_contrast;
  take.shooting.period = from_seconds(c.period_s);
  return take;
}

/// Whereto the ball flies, by the images of its leg around this one; sets its way during a flash.
double heading_of(const KnownPhotograph& known, std::size_t i, double flash_s, NoiseSample& sample) {
  const auto next_to = [&](std::size_t k) { return known.truth[k].leg == known.truth[i].leg; };
  std::size_t a = i, b = i;
  if (i + 1 < known.truth.size() && next_to(i + 1)) b = i + 1;
  if (i > 0 && next_to(i - 1)) a = i - 1;
  if (a == b) return 0.0;
  const double dx = known.truth[b].centre_px.x - known.truth[a].centre_px.x;
  const double dy = known.truth[b].centre_px.y - known.truth[a].centre_px.y;
  sample.picture.motion_px = std::hypot(dx, dy) / (known.times_s[b] - known.times_s[a]) * flash_s;
  return std::atan2(dy, dx);
}

void set_errors(const TrueImage& truth, const reduction::BallImage& image, double heading_rad,
                NoiseSample& sample) {
  sample.found = true;
  const double dx = image.centre_px.x - truth.centre_px.x, dy = image.centre_px.y - truth.centre_px.y;
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  sample.along_px = c * dx + s * dy;
  sample.across_px = c * dy - s * dx;
  if (const auto& cov = image.centre_cov_px2) sample.centre_sd_px = std::sqrt(0.5 * ((*cov)[0] + (*cov)[3]));
  sample.diameter_px = image.diameter_px - truth.diameter_px;
  sample.diameter_sd_px = image.diameter_sd_px.value_or(0.0);
  sample.lowest_px = dy - 0.5 * sample.diameter_px;
  if (!image.equator_rad || !truth.equator_rad) return;
  sample.equator_rad = wrap_half_turn(*image.equator_rad - *truth.equator_rad);
  sample.equator_sd_rad = image.equator_sd_rad.value_or(0.0);
}

host::PictureConditions picture_of(const NoiseCondition& c, double line_width) {
  return {.ball_diameter_px = c.diameter_px,
          .blur_px = c.blur_px,
          .exposure = c.exposure,
          .full_well_e = c.full_well_e,
          .read_noise_e = c.read_noise_e,
          .line_contrast = c.line_contrast,
          .line_width = line_width,
          .step = c.step};
}

void set_images(const KnownPhotograph& known, const reduction::Frame& frame, double flash_s,
                const host::PictureConditions& picture, NoisePhotograph& photograph) {
  std::vector<reduction::PointPx> centres_px;
  for (const TrueImage& truth : known.truth) centres_px.push_back(truth.centre_px);
  const auto overlaps = host::overlaps(centres_px, picture.ball_diameter_px);
  std::vector<const reduction::BallImage*> found(known.truth.size(), nullptr);
  const auto pairs = digitize::pairs_of(known.truth, frame.images);
  for (const digitize::Pair& pair : pairs) found[pair.truth] = &frame.images[pair.image];
  photograph.invented = static_cast<int>(frame.images.size() - pairs.size());
  for (std::size_t i = 0; i < known.truth.size(); ++i) {
    const TrueImage& truth = known.truth[i];
    if (!truth.whole || truth.leg == reduction::Leg::contact) continue;
    NoiseSample sample{.picture = picture, .rebound = truth.leg == reduction::Leg::rebound};
    sample.picture.overlap = overlaps[i];
    const double heading_rad = heading_of(known, i, flash_s, sample);
    if (found[i] != nullptr) set_errors(truth, *found[i], heading_rad, sample);
    photograph.images.push_back(sample);
  }
}

void set_surface(const KnownPhotograph& known, const reduction::Frame& frame, NoisePhotograph& photograph) {
  const auto& line = known.surface_px;
  if (line.size() < 2 || frame.surface_px.empty()) return;
  const double slope = (line[1].y - line[0].y) / (line[1].x - line[0].x);
  double sum_px = 0.0;
  for (const reduction::PointPx& p : frame.surface_px) sum_px += p.y - line[0].y - slope * (p.x - line[0].x);
  photograph.surface_px = sum_px / static_cast<double>(frame.surface_px.size());
  photograph.surface_sd_px = frame.surface_sd_px.value_or(0.0);
}

}  // namespace

Result<NoisePhotograph> noise_photograph(std::uint64_t seed, int number, int each) {
  NoisePhotograph photograph;
  photograph.number = number;
  photograph.condition = draw_condition(seed, (number - 1) / each);
  const auto take = take_of(photograph.condition, seed, number);
  if (!take) return tl::unexpected(take.error());
  const auto known = digitize::known_photograph(*take);
  if (!known) return tl::unexpected(known.error());
  const sim::Appearance look = sim::draw_appearance(take->scene, seed, number);
  const auto result = strobe::digitize::digitize(known->photograph, known->settings);
  if (!result) return tl::unexpected(result.error());
  set_images(*known, result->frame, take->scene.lamps.flash_s,
             picture_of(photograph.condition, look.ball.line_width_m / kBall_m), photograph);
  set_surface(*known, result->frame, photograph);
  return photograph;
}

}  // namespace strobe::studies::design
