// Which flash made which image: how many shots are lost to it, and whether the numbers' standard deviations hold.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "common/messages/lcm_conversions.hpp"
#include "common/reduction/reduce.hpp"
#include "common/units/angles.hpp"
#include "host/assembly/assemble.hpp"
#include "host/assembly/flash_times.hpp"
#include "host/photographs/measure_photograph.hpp"
#include "host/session/shot.hpp"
#include "sim/random/draws.hpp"
#include "tests/studies/digitize/in_order.hpp"
#include "tests/studies/digitize/photographs.hpp"
#include "tests/studies/digitize/shot_message.hpp"
#include "tests/studies/digitize/studies.hpp"

namespace strobe::studies::digitize {

namespace {

using reduction::Flag;
using reduction::Quantity;

/// Noise of a digitizer that renders nothing: of the order of what rendered photographs are measured with.
constexpr double kCentreSd_px = 0.04, kDiameterSd_px = 0.06, kEquatorSd_rad = 0.004, kSurfaceSd_px = 0.1;

/// Commanded instants: the plan's, each later by what the machine lets it wait.
std::vector<Duration> train_of(const Options& options, int shot) {
  sim::Draws draws(options.seed, sim::Purpose::tablet, 1'000'000 + static_cast<std::uint64_t>(shot));
  std::vector<Duration> train;
  for (const Duration offset : options.train)
    train.push_back(offset + from_seconds(1e-6 * options.issue_jitter_us * std::abs(draws.normal())));
  return train;
}

reduction::Frame measured_frame(const KnownPhotograph& known, sim::Draws& draws) {
  reduction::Frame frame;
  frame.ball_diameter_m = known.settings.ball_diameter_m;
  frame.centre_sd_px = kCentreSd_px;
  frame.diameter_sd_px = kDiameterSd_px;
  frame.equator_sd_rad = kEquatorSd_rad;
  frame.surface_sd_px = kSurfaceSd_px;
  for (const double share : {0.0, 0.3, 0.7, 1.0}) {
    const auto& ends = known.scene_truth.surface_px;
    frame.surface_px.push_back(
        {ends[0].x + share * (ends[1].x - ends[0].x),
         ends[0].y + share * (ends[1].y - ends[0].y) + kSurfaceSd_px * draws.normal()});
  }
  for (const TrueImage& truth : known.truth) {
    if (!truth.whole) continue;
    reduction::BallImage image;
    image.source = "auto";
    image.leg = truth.leg;
    image.centre_px = {truth.centre_px.x + kCentreSd_px * draws.normal(),
                       truth.centre_px.y + kCentreSd_px * draws.normal()};
    image.diameter_px = truth.diameter_px + kDiameterSd_px * draws.normal();
    if (truth.equator_rad) image.equator_rad = *truth.equator_rad + kEquatorSd_rad * draws.normal();
    frame.images.push_back(image);
  }
  return frame;
}

struct Done {
  std::string scene;
  int shot = 0;
  reduction::Readout readout;
  reduction::Quantities truth;
  std::optional<std::string> rejected;
  std::string why;  ///< of a flagged shot: what was left out of its fit
};

/// Error over the stated sd, the ball's tolerance included. Returns nullopt if either is missing.
std::optional<double> normalized_error(const Done& done, Quantity q) {
  const auto& value = done.readout.value[q];
  const double sd = std::hypot(done.readout.sd[q].value_or(0.0), done.readout.sd_systematic[q].value_or(0.0));
  if (!value || !done.truth[q] || !(sd > 0.0)) return std::nullopt;
  return (*value - *done.truth[q]) / sd;
}

/// The numbers that are wrong though nothing says so: beyond kWild_sd, the shot neither flagged nor rejected. A normal
/// error is so large once in two million numbers.
std::string wrong_in_silence(const Done& done) {
  std::string wrong;
  if (done.rejected || !done.readout.flags.empty()) return wrong;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto error = normalized_error(done, q);
    if (error && std::abs(*error) > kWild_sd)
      wrong += fmt::format(" {} {:.6g} for {:.6g} ({:+.1f} sd)", name(q), *done.readout.value[q],
                           *done.truth[q], *error);
  }
  return wrong;
}

std::string off(const char* what, double error, std::optional<double> sd) {
  return fmt::format(" {} {:+.3g}{}", what, error, sd ? fmt::format(" ({:+.1f} sd)", error / *sd) : "");
}

std::string errors_of(const TrueImage& truth, const reduction::BallImage& image) {
  const auto& c = image.centre_cov_px2;
  const auto sd = [&](std::size_t k) { return c ? std::optional(std::sqrt((*c)[k])) : std::nullopt; };
  std::string text = off("x", image.centre_px.x - truth.centre_px.x, sd(0)) +
                     off("y", image.centre_px.y - truth.centre_px.y, sd(3)) +
                     off("diameter", image.diameter_px - truth.diameter_px, image.diameter_sd_px);
  if (truth.equator_rad && image.equator_rad)
    text += off("equator", wrap_half_turn(*image.equator_rad - *truth.equator_rad), image.equator_sd_rad);
  return text;
}

/// What of an image was left out of the fit; empty: nothing that was measured.
std::string left_out(const reduction::BallImage& image, const reduction::ImageFit& fit) {
  if (!fit.leg || *fit.leg == reduction::Leg::contact || image.other_leg) return {};
  std::string text = fit.centre_used ? "" : " centre";
  if (fit.centre_used && !fit.diameter_used) text += " diameter";
  if (image.equator_rad && !fit.equator_used) text += " equator";
  return text;
}

std::string what_was_left_out(const KnownPhotograph& known, const reduction::Frame& frame) {
  const auto fits = reduction::image_fits(frame);
  if (!fits) return {};
  const auto pairs = pairs_of(known.truth, frame.images);
  std::string text;
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    const reduction::BallImage& image = frame.images[i];
    const std::string what = left_out(image, (*fits)[i]);
    if (what.empty()) continue;
    text += fmt::format("\n        left out{} of image {} at {:.0f}, {:.0f}, probability {:.4f}:", what,
                        i + 1, image.centre_px.x, image.centre_px.y, image.probability.value_or(1.0));
    const auto pair = std::ranges::find(pairs, i, &Pair::image);
    text += pair == pairs.end() ? " no image of the ball"
                                : errors_of(known.truth[pair->truth], image) +
                                      (known.truth[pair->truth].whole ? "" : ", cut off");
  }
  return text;
}

Result<reduction::Frame> digitized_frame(const Options& options, const KnownPhotograph& known,
                                         const host::RigFile& rig, const strobe_msgs::shot_t& shot) {
  auto settings = host::digitize_settings(rig, known.photograph.width(), known.photograph.height());
  if (!settings) return tl::unexpected(settings.error());
  settings->effort = options.effort;
  std::vector<double>& times_s = settings->flash_times_s.emplace();
  const host::FlashTimes times = host::flash_times(shot);
  for (const host::ObservedFlash& flash : times.seen)
    times_s.push_back(to_seconds(flash.time - times.seen.front().time));
  auto digitized = host::measure(known.photograph, *settings, {}, rig.camera);
  if (!digitized) return tl::unexpected(digitized.error());
  return std::move(digitized->frame);
}

Result<Done> run_shot(const Options& options, Take take) {
  if (!options.train.empty()) take.shooting.train = train_of(options, take.shot);
  const auto known = options.simulated ? known_exposure(take) : known_photograph(take);
  if (!known) return tl::unexpected(known.error());
  const double px_per_m = known->scene_truth.px_per_m_of_ball;
  const double scale_sd = 0.01 * options.scale_sd_percent;
  sim::Draws draws(options.seed, sim::Purpose::tablet, 2'000'000 + static_cast<std::uint64_t>(take.shot));
  const host::RigFile rig = rig_of(take.scene,
                                   {px_per_m * (1.0 + scale_sd * draws.normal()), px_per_m * scale_sd,
                                    take.scene.ball.diameter_m, 0.0},
                                   options.viewpoint ? known->viewpoint_px : std::nullopt);
  strobe_msgs::shot_t shot = shot_message(*known, take.scene, take.shot, to_ns(known->shot.exposure.closed));
  // As with a rig whose machine is as late as its file says, give or take its spread.
  if (!options.train.empty())
    shot.trigger_ns = shot.flashes.front().commanded_ns +
                      to_ns(from_ns(0) + options.train.back() / 2 - from_seconds(take.scene.machine.lag_s));
  host::AssemblySettings assembly = host::assembly_settings(rig);
  assembly.machine_lag_s = take.scene.machine.lag_s;
  assembly.budgets = true;
  if (options.flash_time_sd_us) assembly.analysis.flash_time_sd_s = 1e-6 * *options.flash_time_sd_us;
  if (options.machine_lag_sd_ms) assembly.analysis.machine_lag_sd_s = 1e-3 * *options.machine_lag_sd_ms;
  auto frame =
      options.simulated ? measured_frame(*known, draws) : digitized_frame(options, *known, rig, shot);
  if (!frame) return tl::unexpected(frame.error());
  if (options.simulated) {
    frame->px_per_m = rig.camera.px_per_m;
    frame->px_per_m_sd = rig.camera.px_per_m_sd;
  }
  const host::ShotReadout read = host::shot_readout(shot, messages::frame_to_lcm(*frame), assembly);
  Done done{take.scene.name, take.shot, read.readout, known->shot.truth, host::rejection_reason(read.readout),
            {}};
  if (read.matched && !read.readout.flags.empty()) done.why = what_was_left_out(*known, *read.matched);
  return done;
}

class Tally {
 public:
  void add(const Done& done) {
    ++shots_;
    for (std::size_t f = 0; f < reduction::kFlagCount; ++f)
      flagged_[f] += done.readout.flags.has(static_cast<Flag>(f)) ? 1 : 0;
    if (done.rejected) ++rejected_[done.rejected->substr(0, done.rejected->find(" ("))];
    for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
      const auto error = normalized_error(done, static_cast<Quantity>(i));
      if (!error) continue;
      ++count_[i];
      squares_[i] += *error * *error;
    }
    tell_flags(done);
    if (const std::string wrong = wrong_in_silence(done); !wrong.empty())
      wrong_.push_back(fmt::format("{} shot {}:{}", done.scene, done.shot, wrong));
  }

  void print(const std::string& name, bool each_shot = true) const {
    double sum = 0.0, count = 0.0;
    std::string each;
    for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
      if (count_[i] == 0) continue;
      sum += squares_[i], count += count_[i];
      each += fmt::format(" {} {:.2f}", reduction::kQuantityNames[i], squares_[i] / count_[i]);
    }
    fmt::print("{:<16} {:>5} shots, squared errors over variances {:.3f}:{}\n", name, shots_, sum / count,
               each);
    for (const auto& [why, times] : rejected_) fmt::print("    rejected {}: {}\n", times, why);
    for (std::size_t f = 0; f < reduction::kFlagCount; ++f)
      if (flagged_[f] > 0) fmt::print("    {} {}\n", reduction::kFlagNames[f], flagged_[f]);
    if (!wrong_.empty())
      fmt::print("    {} with numbers beyond {:g} sd and no flag\n", wrong_.size(), kWild_sd);
    for (const auto* told : {&wrong_, &told_})
      for (std::size_t i = 0; each_shot && i < told->size(); ++i) fmt::print("      {}\n", (*told)[i]);
    std::fflush(stdout);
  }

 private:
  void tell_flags(const Done& done) {
    std::string flags;
    for (std::size_t f = 0; f < reduction::kFlagCount; ++f)
      if (done.readout.flags.has(static_cast<Flag>(f))) flags += fmt::format(" {}", reduction::kFlagNames[f]);
    if (done.rejected) flags += " rejected: " + *done.rejected;
    if (flags.empty()) return;
    std::string ratios;
    for (std::size_t kind = 0; kind < reduction::kMeasurementKindCount; ++kind)
      if (const auto& ratio = done.readout.residual_ratios.by_kind[kind])
        ratios += fmt::format(" {} {:.2f}", reduction::kMeasurementKindNames[kind], *ratio);
    told_.push_back(
        fmt::format("{} shot {}:{}; residuals over sds{}{}", done.scene, done.shot, flags, ratios, done.why));
  }

  int shots_ = 0;
  std::array<int, reduction::kFlagCount> flagged_{};
  std::map<std::string, int> rejected_;
  std::array<double, reduction::kQuantityCount> squares_{};
  std::array<int, reduction::kQuantityCount> count_{};
  std::vector<std::string> wrong_, told_;
};

}  // namespace

Result<void> study_matches(const Options& options) {
  const auto names = scene_names(options.scenes);
  if (!names) return tl::unexpected(names.error());
  auto scenes = load_scenes(*names);
  if (!scenes) return tl::unexpected(scenes.error());
  const auto shots = static_cast<std::size_t>(options.shots.value_or(20));
  Tally tally, all;
  const auto done = try_in_order(
      scenes->size() * shots, options.jobs,
      [&](std::size_t i) {
        return run_shot(
            options,
            {.scene = (*scenes)[i / shots],
             .seed = options.seed,
             .shot = options.first_shot + static_cast<int>(i % shots),
             .kept_in = options.keep,
             .independent = options.independent});
      },
      [&](std::size_t i, const Done& one) {
        tally.add(one);
        all.add(one);
        if ((i + 1) % shots != 0) return;
        tally.print((*scenes)[i / shots].name);
        tally = {};
      });
  if (!done) return done;
  if (scenes->size() > 1) all.print("all", false);
  return {};
}

}  // namespace strobe::studies::digitize
