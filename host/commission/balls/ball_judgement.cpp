#include "host/commission/balls/ball_judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/commission/core/limits.hpp"
#include "host/commission/core/sample.hpp"

namespace strobe::commission {
namespace {

/// Of a sound rig a mean is beyond its margin, and an sd below its bound, once in 10,000 times: as a probability, and as
/// the normal deviate that is exceeded so often.
constexpr double kMeanProbability = 0.9999, kOnceInTenThousand = 3.72;
constexpr double kDegrees = 180.0 / std::numbers::pi;
/// No plate is levelled, and no inclinometer read, better.
constexpr double kInclination_deg = 0.5;

StepResult passing(const std::string& id, double value, std::optional<double> sd, std::string unit,
                   std::string limit) {
  StepResult result;
  result.id = id;
  result.state = StepState::passed;
  result.value = value;
  result.sd = sd;
  result.unit = std::move(unit);
  result.limit = std::move(limit);
  return result;
}

int counted(std::span<const BallShot> shots) {
  return static_cast<int>(std::ranges::count_if(shots, [](const BallShot& s) { return !s.rejected; }));
}

std::string first_rejection(std::span<const BallShot> shots) {
  for (const BallShot& shot : shots)
    if (shot.rejected) return *shot.rejected;
  return "";
}

}  // namespace

StepResult judge_gravity(const std::string& id, const FreeFall& fall, double local_mps2,
                         double scale_share_sd) {
  const double off = fall.g_mps2 / local_mps2 - 1.0;
  const double sd = std::hypot(fall.g_sd_mps2 / local_mps2, scale_share_sd);
  const double limit = std::max(kGravityTolerance, kCertain_sd * sd);
  StepResult result = passing(id, fall.g_mps2, sd * local_mps2, "m/s^2",
                              fmt::format("{:.4f} m/s^2 within {:.2f} %", local_mps2, 100.0 * limit));
  result.words =
      fmt::format("balls fall with {:.3f} ± {:.3f} m/s^2, {:+.2f} % off the place's; {} legs, {} images",
                  fall.g_mps2, sd * local_mps2, 100.0 * off, fall.legs, fall.images);
  result.figures = {
      {"gravity_mps2", fall.g_mps2, sd * local_mps2, local_mps2, fall.images},
      {"drag_share", fall.drag_share, {}, 1.0, 0},
      {"chi_squared_ratio", fall.chi_squared / std::max(1, fall.degrees_of_freedom), {}, 1.0, fall.images},
      {"outliers", static_cast<double>(fall.outliers), {}, 0.0, 0}};
  if (std::abs(off) > limit)
    mark_failed(
        result, "gravity_off",
        "the scale is off by as much, or the clock by half: calibrate the camera again with the board "
        "in the plane "
        "where balls fly; see whether the ball's size is off by as much (step scale)");
  else if (sd > kMaxGravitySd * 2.0)
    mark_failed(result, "gravity_uncertain",
                "drop more balls, nearer to the middle of the plate and without spin");
  return result;
}

StepResult judge_inclination(const std::string& id, const FreeFall& fall, double stated_deg) {
  const double found = fall.inclination_rad * kDegrees, sd = fall.inclination_sd_rad * kDegrees;
  const double limit = std::max(kInclination_deg, kCertain_sd * sd);
  StepResult result =
      passing(id, found, sd, "deg", fmt::format("{:.2f} deg within {:.2f}", stated_deg, limit));
  result.words =
      fmt::format("balls fall at {:.2f} ± {:.2f} deg to the plate's normal, the rig file says {:.2f}", found,
                  sd, stated_deg);
  result.figures = {{"inclination_deg", found, sd, stated_deg, fall.images}};
  if (std::abs(found - stated_deg) > limit)
    mark_failed(result, "plate_inclined",
                "measure the plate with an inclinometer, and enter surface_angle_deg in [analysis]");
  return result;
}

StepResult judge_scale(const std::string& id, const ScaleCheck& check, double diameter_share_sd,
                       double scale_share_sd) {
  const double off = check.ratio - 1.0;
  // The digitizer's own error of a diameter is below 0.02 % of it (host/digitize/README.md).
  constexpr double kDigitizer = 2e-4, kMatters = 0.004;
  const double sd =
      std::hypot(std::hypot(check.ratio_sd, diameter_share_sd), std::hypot(scale_share_sd, kDigitizer));
  const double limit = std::max(kMatters, kCertain_sd * sd);
  StepResult result =
      passing(id, 100.0 * off, 100.0 * sd, "%", fmt::format("0 within {:.2f} %", 100.0 * limit));
  result.words =
      fmt::format("balls look {:+.2f} ± {:.2f} % larger than scale and diameter say; {} images of {} balls",
                  100.0 * off, 100.0 * sd, check.images, check.shots);
  result.figures = {{"size_off_percent", 100.0 * off, 100.0 * sd, 0.0, check.images}};
  if (std::abs(off) > limit)
    mark_failed(
        result, "scale_off",
        "measure the ball's diameter again, and calibrate with the board in the plane where balls fly; "
        "where step "
        "gravity passes, it is the ball or the plane");
  return result;
}

StepResult judge_squareness(const std::string& id, const ScaleCheck& check) {
  const bool sideways = std::abs(check.across) >= std::abs(check.upwards);
  const double slope = sideways ? check.across : check.upwards;
  const double sd = sideways ? check.across_sd : check.upwards_sd;
  const auto beyond = [](double value, double value_sd) {
    return std::abs(value) > std::max(kMaxSlope, kCertain_sd * value_sd);
  };
  StepResult result = passing(id, 100.0 * slope, 100.0 * sd, "%",
                              fmt::format("0 within {:.2f} % over the photograph's width and height",
                                          100.0 * std::max(kMaxSlope, kCertain_sd * sd)));
  result.words = fmt::format(
      "balls grow by {:+.2f} ± {:.2f} % from left to right, {:+.2f} ± {:.2f} % upwards", 100.0 * check.across,
      100.0 * check.across_sd, 100.0 * check.upwards, 100.0 * check.upwards_sd);
  result.figures = {{"across_percent", 100.0 * check.across, 100.0 * check.across_sd, 0.0, check.images},
                    {"upwards_percent", 100.0 * check.upwards, 100.0 * check.upwards_sd, 0.0, check.images}};
  if (beyond(check.across, check.across_sd) || beyond(check.upwards, check.upwards_sd))
    mark_failed(
        result, "camera_tilted",
        "the camera has moved since its calibration, or balls fly towards the lens or away: calibrate "
        "again with the "
        "board in the plane where balls fly");
  return result;
}

StepResult judge_throws(const std::string& id, std::span<const BallShot> shots, bool gate_fitted) {
  int none = 0, several = 0, unseen = 0, without_gate = 0;
  int most = 0;
  for (const BallShot& shot : shots) {
    const bool seen = shot.images > 0;
    none += !seen && (!gate_fitted || shot.gate_edges == 0);
    several += shot.gate_edges > 1;
    unseen += !seen && shot.gate_edges > 0;
    without_gate += seen && gate_fitted && shot.gate_edges == 0;
    most = std::max(most, shot.gate_edges);
  }
  const int count = static_cast<int>(shots.size());
  StepResult result = passing(id, static_cast<double>(count - none - several), {}, "",
                              fmt::format("each of {} throws is one ball", count));
  result.words = fmt::format("{} throws: {} without a ball, {} with several, {} balls seen by the gate alone",
                             count, none, several, unseen);
  result.figures = {{"throws", static_cast<double>(count), {}, {}, 0},
                    {"without_ball", static_cast<double>(none), {}, 0.0, 0},
                    {"with_several", static_cast<double>(several), {}, 0.0, 0},
                    {"gate_alone", static_cast<double>(unseen), {}, 0.0, 0},
                    {"without_gate", static_cast<double>(without_gate), {}, 0.0, 0}};
  if (several > 0)
    mark_failed(
        result, "several_balls",
        "the machine throws more than one ball a trigger, or the gate's beam flickers: watch one throw");
  else if (none > 0)
    mark_failed(
        result, "no_ball",
        "no ball came: is the machine fed and its trigger heard? If one was thrown, it was not in the "
        "view while the "
        "shutter was open: lag_ms in [machine], the camera's folder and focus");
  else if (unseen > 0)
    mark_failed(result, "ball_unseen",
                "balls come but are not on the photograph: lag_ms in [machine], aim, exposure");
  else if (without_gate > 0)
    mark_failed(
        result, "gate_dead",
        "balls are on the photograph but the gate saw none: its beam, wire and line; without one leave "
        "gate out of [lines]");
  return result;
}

StepResult judge_flashes(const std::string& id, std::span<const BallShot> shots) {
  double worst = 0.0;
  int found = 0, uncoded = 0, images = 0, flashes = 0;
  for (const BallShot& shot : shots) {
    if (shot.rejected || !shot.readout.flashes) continue;
    const auto& imaged = *shot.readout.flashes;
    ++found;
    uncoded += !imaged.coded;
    if (imaged.coded) worst = std::max(worst, imaged.misassignment_probability);
    images += shot.images;
    flashes += imaged.last - imaged.first + 1;
  }
  StepResult result =
      passing(id, 100.0 * worst, {}, "%", "each photograph's flashes are known with 99 % or more");
  result.words = fmt::format(
      "on {} of {} photographs the flashes were found; {} images for {} flashes; at worst {:.2g} % doubt",
      found, shots.size(), images, flashes, 100.0 * worst);
  result.figures = {{"photographs", static_cast<double>(shots.size()), {}, {}, 0},
                    {"matched", static_cast<double>(found), {}, static_cast<double>(shots.size()), 0},
                    {"images", static_cast<double>(images), {}, {}, 0},
                    {"flashes", static_cast<double>(flashes), {}, {}, 0}};
  // A digitizer misses an image in a thousand; a ball in contact may be hidden by others. Half of the shots is far from both.
  if (2 * found <= static_cast<int>(shots.size()))
    mark_failed(result, "flashes_unmatched",
                first_rejection(shots).empty() ? "look at a photograph: are all images of one ball?"
                                               : "of one photograph: " + first_rejection(shots));
  else if (uncoded < found && worst > 0.01)
    mark_failed(result, "code_ambiguous",
                "the code of the train is not told by the images: longer exposure or more flashes");
  return result;
}

StepResult judge_noise(const std::string& id, std::span<const BallShot> shots) {
  using reduction::MeasurementKind;
  double chi_squared = 0.0, freedom = 0.0;
  Sample equators;
  for (const BallShot& shot : shots) {
    const auto& ratios = shot.readout.residual_ratios.by_kind;
    if (shot.rejected || shot.centres <= 0) continue;
    if (const auto& of_equator = ratios[static_cast<std::size_t>(MeasurementKind::equator)])
      equators.add(*of_equator);
    const auto& of_centre = ratios[static_cast<std::size_t>(MeasurementKind::centre)];
    if (!of_centre) continue;
    chi_squared += *of_centre * *of_centre * shot.centres;
    freedom += shot.centres;
  }
  if (freedom < 10.0)
    return failed(id, "no_residuals", "too few balls were measured to tell their noise",
                  "let step throws and flashes pass first");
  const double ratio = std::sqrt(chi_squared / freedom);
  // A root of chi squared over nu scatters by 1/sqrt(2 nu): for 200 degrees of freedom by 5 %. Stated sds are themselves
  // good to a third (host/digitize/README.md). The equators are not judged: a line that is drawn a degree off the equator lies
  // further off than any noise, alike in all images of a leg.
  const double limit = 1.35 + kCertain_sd / std::sqrt(2.0 * freedom);
  StepResult result =
      passing(id, ratio, 1.0 / std::sqrt(2.0 * freedom), "", fmt::format("at most {:.2f}", limit));
  result.words = fmt::format(
      "centres lie {:.2f} times as far off their flights as they state; {:.0f} degrees of freedom", ratio,
      freedom);
  result.figures = {{"residual_ratio", ratio, 1.0 / std::sqrt(2.0 * freedom), 1.0, static_cast<int>(freedom)},
                    {"equator_ratio", equators.mean(), {}, 1.0, equators.count()}};
  if (ratio > limit)
    mark_failed(
        result, "noisy",
        "something moves that should not (camera, plate, lamps that light from two places), or the lens is "
        "not calibrated");
  return result;
}

StepResult judge_repeatability(const std::string& id, std::span<const BallShot> shots,
                               std::optional<double> stated_lag_s, double view_width_m) {
  Sample lag, spot, speed;
  for (const BallShot& shot : shots) {
    if (shot.lag_s) lag.add(1e3 * *shot.lag_s);
    if (shot.spot_m) spot.add(1e3 * *shot.spot_m);
    const auto v = shot.readout.value[reduction::Quantity::v_td_mps];
    if (v && !shot.rejected) speed.add(*v);
  }
  if (lag.count() < 2 || speed.count() < 2)
    return failed(id, "too_few_balls",
                  fmt::format("of {} balls only {} were measured", shots.size(), counted(shots)),
                  "let step throws and flashes pass first");
  // A tenth of the view, so that the bounce stays in it; 10 ms of lag move the ball by less than the train's margins.
  constexpr double kLag_ms = 10.0, kLagSd_ms = 15.0, kSpeedSd = 0.05;
  const double spot_limit_mm = 1e3 * 0.1 * view_width_m;
  const double stated_ms = 1e3 * stated_lag_s.value_or(1e-3 * lag.mean());
  const double limit = kLag_ms + lag.mean_margin(kMeanProbability);
  StepResult result =
      passing(id, lag.mean(), lag.mean_sd(), "ms",
              fmt::format("{:.0f} ± {:.0f} ms; spread of lag {:.0f} ms, spot {:.0f} mm, speed {:.0f} %",
                          stated_ms, limit, kLagSd_ms, spot_limit_mm, 100.0 * kSpeedSd));
  result.words = fmt::format(
      "balls come {:.1f} ± {:.1f} ms after the trigger; from ball to ball lag {:.1f} ms, spot {:.1f} mm, "
      "speed {:.2f} m/s of {:.2f}",
      lag.mean(), lag.mean_sd(), lag.sd(), spot.sd(), speed.sd(), speed.mean());
  result.figures = {{"lag_ms", lag.mean(), lag.mean_sd(), stated_ms, lag.count()},
                    {"lag_sd_ms", lag.sd(), {}, {}, lag.count()},
                    {"spot_sd_mm", spot.sd(), {}, {}, spot.count()},
                    {"speed_mps", speed.mean(), speed.mean_sd(), {}, speed.count()},
                    {"speed_sd_mps", speed.sd(), {}, {}, speed.count()}};
  if (std::abs(lag.mean() - stated_ms) > limit)
    mark_failed(result, "machine_lag_off",
                fmt::format("write lag_ms = {:.0f} into [machine] and start strobed anew", lag.mean()));
  else if (lag.sd_lower_bound(kOnceInTenThousand) > kLagSd_ms)
    mark_failed(result, "lag_spread",
                "the machine's trigger varies: use the gate (train = \"gated\"), or look at its relay");
  else if (spot.sd_lower_bound(kOnceInTenThousand) > spot_limit_mm ||
           speed.sd_lower_bound(kOnceInTenThousand) > kSpeedSd * speed.mean())
    mark_failed(result, "machine_spread",
                "the machine scatters more than a series can average: warm it up, look at wheels and balls");
  return result;
}

}  // namespace strobe::commission
