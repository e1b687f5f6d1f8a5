#include "host/commission/ball_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/geometry/line.hpp"
#include "host/commission/picture_quality.hpp"
#include "host/commission/scale_check.hpp"
#include "host/commission/shot_step.hpp"
#include "host/commission/statistics.hpp"
#include "host/commission/steps.hpp"

namespace strobe::commission {
namespace {

int balls(const host::RigFile& rig) { return rig.commission.balls * rig.commission.times; }

int counted(std::span<const BallShot> shots) {
  return static_cast<int>(std::ranges::count_if(shots, [](const BallShot& s) { return !s.rejected; }));
}

std::string first_rejection(std::span<const BallShot> shots) {
  for (const BallShot& shot : shots)
    if (shot.rejected) return *shot.rejected;
  return "";
}

using reduction::Frame;

/// A camera that delivers nothing is not waited for ball after ball.
constexpr int kMaxWithoutPhotograph = 2;

double in_photograph_width_m(const host::RigFile& rig, const Frame& frame, double width_px) {
  const double px_per_m = rig.camera.px_per_m.value_or(frame.px_per_m.value_or(0.0));
  return px_per_m > 0.0 ? width_px / px_per_m : 0.6;
}

/// Two coordinates of each centre, but four of each leg.
int freedom_of(const Frame& frame) {
  const auto centres = std::ranges::count_if(frame.images, [](const reduction::BallImage& image) {
    return image.leg == Leg::incoming || image.leg == Leg::rebound;
  });
  return std::max(0, 2 * static_cast<int>(centres) - 8);
}

struct Touchdown {
  double time_s = 0.0;  ///< of the frame
  double spot_m = 0.0;
};

/// Where the line through the last two images before the plate comes down to a radius above it.
std::optional<Touchdown> touchdown_of(const Frame& frame, double px_per_m) {
  std::vector<const reduction::BallImage*> incoming;
  for (const auto& image : frame.images)
    if (image.leg == Leg::incoming) incoming.push_back(&image);
  std::vector<Eigen::Vector2d> points;
  for (const auto& p : frame.surface_px) points.emplace_back(p.x, p.y);
  const auto line = geometry::fit_line(points);
  if (incoming.size() < 2 || !line || px_per_m <= 0.0) return std::nullopt;
  const auto seen = [&](const reduction::BallImage& image) {
    return line->coordinates(Eigen::Vector2d(image.centre_px.x, image.centre_px.y));
  };
  const reduction::BallImage &before = *incoming[incoming.size() - 2], &last = *incoming.back();
  const Eigen::Vector2d a = seen(before), b = seen(last);
  if (a.y() <= b.y()) return std::nullopt;
  const double further = (b.y() - 0.5 * last.diameter_px) / (a.y() - b.y());
  return Touchdown{last.time_s + further * (last.time_s - before.time_s),
                   (b.x() + further * (b.x() - a.x()) + line->origin().x()) / px_per_m};
}

/// The instant of the first image, after the machine's trigger.
std::optional<double> first_image_s(const host::Shot& shot) {
  const auto& imaged = shot.readout.flashes;
  const MonoTime trigger = from_ns(shot.summary->trigger_ns);
  if (!imaged || !known(trigger)) return std::nullopt;
  for (const strobe_msgs::flash_t& flash : shot.summary->flashes)
    if (flash.flash_index == imaged->first && known(from_ns(flash.issue_end_ns)))
      return to_seconds(from_ns(flash.issue_end_ns) - trigger);
  return std::nullopt;
}

class BallStep final : public ShotStep {
 public:
  BallStep()
      : ShotStep({{"throws", "each throw is one ball", {"machine", "lines"}},
                  {"focus", "sharp edges of balls", {"camera"}},
                  {"exposure", "neither white nor dark", {"camera", "lamps"}},
                  {"transfer", "numbers proportional to light", {"camera"}},
                  {"flashes", "flashes against the photograph", {"lamps", "sensors", "plan", "camera"}},
                  {"scale", "scale by the balls' size", {"ball", "camera"}},
                  {"square", "camera square to the balls' plane", {"camera"}},
                  {"noise", "noise against what is stated", {"camera", "ball", "analysis"}},
                  {"repeatability", "lag, spot and speed from ball to ball", {"machine"}}},
                 {.operator_acts = true, .outputs = true, .machine = true, .photographs = true},
                 {.missing = kMaxWithoutPhotograph, .measure = true}) {}
  std::string briefing(const host::RigFile& rig) const override {
    return fmt::format(
        "{} BALLS ARE THROWN, with lamps and shutter. Slowest speed; feed the machine, clear the lane, "
        "nobody in front of it; key on, e-stop released.",
        balls(rig));
  }

  void begin(const Situation& situation) override {
    ShotStep::begin(situation);
    gate_edges_.clear();
    edges_ = 0;
  }
  void on_event(const strobe_msgs::event_t& event, HostTime) override {
    if (event.kind == strobe_msgs::event_t::SHOT_STARTED) edges_ = 0;
    if (event.kind == strobe_msgs::event_t::GATE) ++edges_;
  }

 private:
  std::vector<Fire> shots(const host::RigFile& rig) const override {
    Fire fire;
    fire.plan = rig.plan.shot();
    fire.plan.dry = false;
    fire.words = "a ball is thrown";
    fire.photograph = true;
    return std::vector<Fire>(static_cast<std::size_t>(balls(rig)), fire);
  }
  StepResult left_out(const std::string&) const override {
    return skipped("no balls were measured", "let step throws pass first");
  }
  void on_sound_shot() override { gate_edges_.push_back(std::exchange(edges_, 0)); }
  std::vector<StepResult> judge(const std::vector<SoundShot>& sound, const host::RigFile& rig) override;

  std::vector<int> gate_edges_;  ///< of each sound shot
  int edges_ = 0;                ///< since the last one
};

std::vector<StepResult> BallStep::judge(const std::vector<SoundShot>& sound, const host::RigFile& rig) {
  std::vector<BallShot> shots(sound.size());
  std::vector<PictureQuality> qualities;
  std::vector<Frame> frames;
  double width_px = 1.0, height_px = 1.0, px_per_m = rig.camera.px_per_m.value_or(0.0);
  for (std::size_t k = 0; k < sound.size(); ++k) {
    const host::Shot& fired = sound[k].fired;
    BallShot& shot = shots[k];
    shot.rejected = fired.rejected;
    shot.readout = fired.readout;
    shot.gate_edges = gate_edges_[k];
    if (!sound[k].measured) continue;
    const host::MeasuredPhotograph& m = *sound[k].measured;
    const Frame& frame = m.found.frame;
    if (px_per_m <= 0.0 && m.settings.px_per_m) px_per_m = *m.settings.px_per_m;
    width_px = m.photograph.width(), height_px = m.photograph.height();
    shot.images = static_cast<int>(frame.images.size());
    shot.centres = freedom_of(frame);
    const auto touchdown = touchdown_of(frame, px_per_m);
    const auto first = first_image_s(fired);
    if (touchdown) shot.spot_m = touchdown->spot_m;
    if (touchdown && first && !shot.rejected)
      shot.lag_s = *first + touchdown->time_s - frame.images.front().time_s;
    qualities.push_back(picture_quality(m.photograph, m.settings.map, m.found));
    frames.push_back(frame);
  }
  std::vector<StepResult> results{judge_throws(shots, rig.limits.gate_fitted), judge_focus(qualities),
                                  judge_exposure(qualities), judge_transfer(qualities), judge_flashes(shots)};
  if (px_per_m <= 0.0) {
    results.insert(
        results.end(), 2,
        failed("no_scale", "the rig file has no scale", "calibrate the camera with a printed board"));
  } else if (const auto check = check_scale(frames, px_per_m, rig.ball.diameter_m, width_px, height_px)) {
    results.push_back(judge_scale(*check, rig.ball.diameter_sd_m / rig.ball.diameter_m,
                                  rig.camera.px_per_m_sd.value_or(0.0) / px_per_m));
    results.push_back(judge_squareness(*check));
  } else {
    results.insert(results.end(), 2,
                   failed("no_images", check.error().message, "let step focus and exposure pass first"));
  }
  results.push_back(judge_noise(shots));
  const double view_m = frames.empty() ? 0.6 : in_photograph_width_m(rig, frames.front(), width_px);
  results.push_back(judge_repeatability(shots, rig.machine_lag_s, view_m));
  return results;
}

}  // namespace

StepResult judge_throws(std::span<const BallShot> shots, bool gate_fitted) {
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
  StepResult result = passed(static_cast<double>(count - none - several), {}, "",
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
    mark_failed(result, "no_ball",
                "no ball came: is the machine fed and its trigger heard? If one was thrown, it was not in "
                "the view while the shutter was open: lag_ms in [machine], the camera's folder and focus");
  else if (unseen > 0)
    mark_failed(result, "ball_unseen",
                "balls come but are not on the photograph: lag_ms in [machine], aim, exposure");
  else if (without_gate > 0)
    mark_failed(result, "gate_dead",
                "balls are on the photograph but the gate saw none: its beam, wire and line; without one "
                "leave gate out of [lines]");
  return result;
}

StepResult judge_flashes(std::span<const BallShot> shots) {
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
  StepResult result = passed(100.0 * worst, {}, "%", "each photograph's flashes are known with 99 % or more");
  result.words = fmt::format(
      "on {} of {} photographs the flashes were found; {} images for {} flashes; at worst {:.2g} % doubt",
      found, shots.size(), images, flashes, 100.0 * worst);
  result.figures = {{"photographs", static_cast<double>(shots.size()), {}, {}, 0},
                    {"matched", static_cast<double>(found), {}, static_cast<double>(shots.size()), 0},
                    {"images", static_cast<double>(images), {}, {}, 0},
                    {"flashes", static_cast<double>(flashes), {}, {}, 0}};
  // A digitizer misses an image in a thousand; a ball in contact may be hidden by others. Half of the shots
  // is far from both.
  if (2 * found <= static_cast<int>(shots.size()))
    mark_failed(result, "flashes_unmatched",
                first_rejection(shots).empty() ? "look at a photograph: are all images of one ball?"
                                               : "of one photograph: " + first_rejection(shots));
  else if (uncoded < found && worst > 0.01)
    mark_failed(result, "code_ambiguous",
                "the images do not determine the code of the train: longer exposure or more flashes");
  return result;
}

StepResult judge_noise(std::span<const BallShot> shots) {
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
    return failed("no_residuals", "too few balls were measured to tell their noise",
                  "let step throws and flashes pass first");
  const double ratio = std::sqrt(chi_squared / freedom);
  // A root of chi squared over nu scatters by 1/sqrt(2 nu) of it: for 200 degrees of freedom by 5 %. Stated
  // sds are themselves good to a third (host/digitize/README.md). The equators are not judged: a line that is
  // drawn a degree off the equator lies further off than any noise, alike in all images of a leg.
  constexpr double kMaxRatio = 1.35;
  const double sd = ratio / std::sqrt(2.0 * freedom);
  StepResult result = passed(ratio, sd, "", fmt::format("at most {:.2f}", kMaxRatio));
  result.words = fmt::format(
      "centres scatter about their flights {:.2f} times as much as their stated sd; {:.0f} degrees of "
      "freedom",
      ratio, freedom);
  result.figures = {{"residual_ratio", ratio, sd, 1.0, static_cast<int>(freedom)},
                    {"equator_ratio", equators.mean(), {}, 1.0, equators.count()}};
  hold(
      result, interval(ratio, sd), {.most = kMaxRatio}, "noisy",
      "something moves that should not (camera, plate, lamps that light from two places), or the lens is not "
      "calibrated");
  return result;
}

StepResult judge_repeatability(std::span<const BallShot> shots, std::optional<double> stated_lag_s,
                               double view_width_m) {
  Sample lag, spot, speed;
  for (const BallShot& shot : shots) {
    if (shot.lag_s) lag.add(1e3 * *shot.lag_s);
    if (shot.spot_m) spot.add(1e3 * *shot.spot_m);
    const auto v = shot.readout.value[reduction::Quantity::v_td_mps];
    if (v && !shot.rejected) speed.add(*v);
  }
  if (lag.count() < 2 || speed.count() < 2)
    return failed("too_few_balls",
                  fmt::format("of {} balls only {} were measured", shots.size(), counted(shots)),
                  "let step throws and flashes pass first");
  // A tenth of the view, so that the bounce stays in it; 10 ms of lag move the ball by less than the train's
  // margins.
  constexpr double kLag_ms = 10.0, kLagSd_ms = 15.0, kSpeedSd = 0.05;
  const double spot_limit_mm = 1e3 * 0.1 * view_width_m;
  const double stated_ms = 1e3 * stated_lag_s.value_or(1e-3 * lag.mean());
  StepResult result =
      passed(lag.mean(), lag.mean_sd(), "ms",
             fmt::format("{:.0f} ± {:.0f} ms; spread of lag {:.0f} ms, spot {:.0f} mm, speed {:.0f} %",
                         stated_ms, kLag_ms, kLagSd_ms, spot_limit_mm, 100.0 * kSpeedSd));
  result.words = fmt::format(
      "balls come {:.1f} ± {:.1f} ms after the trigger; from ball to ball lag {:.1f} ms, spot {:.1f} mm, "
      "speed {:.2f} m/s of {:.2f}",
      lag.mean(), lag.mean_sd(), lag.sd(), spot.sd(), speed.sd(), speed.mean());
  result.figures = {{"lag_ms", lag.mean(), lag.mean_sd(), stated_ms, lag.count()},
                    {"lag_sd_ms", lag.sd(), {}, {}, lag.count()},
                    {"spot_sd_mm", spot.sd(), {}, {}, spot.count()},
                    {"speed_mps", speed.mean(), speed.mean_sd(), {}, speed.count()},
                    {"speed_sd_mps", speed.sd(), {}, {}, speed.count()}};
  hold(result, lag.mean_interval(), within(kLag_ms, stated_ms), "machine_lag_off",
       fmt::format("write lag_ms = {:.0f} into [machine] and start strobed anew", lag.mean()));
  hold(result, lag.sd_interval(), {.most = kLagSd_ms}, "lag_spread",
       "the machine's trigger varies: use the gate (train = \"gated\"), or look at its relay");
  for (const auto& [spread, most] : {std::pair{spot.sd_interval(), spot_limit_mm},
                                     std::pair{speed.sd_interval(), kSpeedSd * speed.mean()}})
    hold(result, spread, {.most = most}, "machine_spread",
         "the machine scatters more than a series can average: warm it up, look at wheels and balls");
  return result;
}

std::unique_ptr<Step> ball_step() { return std::make_unique<BallStep>(); }

}  // namespace strobe::commission
