#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <functional>

#include "common/messages/lcm_conversions.hpp"
#include "common/reduction/reduce.hpp"
#include "host/assembly/assemble.hpp"
#include "host/assembly/flash_times.hpp"
#include "host/photographs/measure_photograph.hpp"
#include "sim/random/draws.hpp"
#include "tests/studies/digitize/in_order.hpp"
#include "tests/studies/digitize/photographs.hpp"
#include "tests/studies/digitize/shot_message.hpp"
#include "tests/studies/digitize/studies.hpp"

namespace strobe::studies::digitize {

namespace {

using reduction::Frame;
using reduction::Leg;
using reduction::Quantity;

constexpr std::array kChecked{Quantity::vx_td_mps, Quantity::vy_td_mps,      Quantity::vx_lo_mps,
                              Quantity::vy_lo_mps, Quantity::omega_td_radps, Quantity::omega_lo_radps,
                              Quantity::e};
constexpr std::size_t kCount = kChecked.size();

double tolerance(Quantity quantity, double truth) {
  switch (quantity) {
    case Quantity::omega_td_radps:
    case Quantity::omega_lo_radps:
      return std::max(0.01 * std::abs(truth), 1.5);
    case Quantity::e:
      return 0.003;
    default:
      return 0.05;
  }
}

/// What is taken as it was measured; the rest is true.
enum class Source { scale, ball, times, centres, diameters, equators, surface };
constexpr std::size_t kSources = 7;
using Sources = std::bitset<kSources>;
Sources only(Source source) { return Sources(1U << static_cast<unsigned>(source)); }

struct Part {
  const char* name;
  Sources measured;
};
const std::array<Part, 9> kParts{{{"nothing (the fit's model)", {}},
                                  {"scale", only(Source::scale)},
                                  {"ball's diameter", only(Source::ball)},
                                  {"flash stamps", only(Source::times)},
                                  {"centres", only(Source::centres)},
                                  {"diameters", only(Source::diameters)},
                                  {"equators", only(Source::equators)},
                                  {"surface line", only(Source::surface)},
                                  {"all of them", Sources(~0U)}}};

/// Errors of a readout; NaN: it has no such number.
struct Errors {
  std::array<double, kCount> error{};
  std::array<double, kCount> sd{};  ///< stated, the ball's tolerance included
  std::array<bool, kCount> within{};

  bool all_within() const { return std::ranges::all_of(within, std::identity{}); }
};

/// Of a ball without a line no spin may be told.
Errors errors_of(const reduction::Readout& readout, reduction::Quantities truth, bool line) {
  if (!line) truth[Quantity::omega_td_radps] = truth[Quantity::omega_lo_radps] = std::nullopt;
  Errors errors;
  for (std::size_t i = 0; i < kCount; ++i) {
    const Quantity q = kChecked[i];
    errors.error[i] = readout.value[q] && truth[q] ? *readout.value[q] - *truth[q] : std::nan("");
    errors.sd[i] = std::hypot(readout.sd[q].value_or(0.0), readout.sd_systematic[q].value_or(0.0));
    errors.within[i] =
        truth[q] ? std::abs(errors.error[i]) <= tolerance(q, *truth[q]) : !readout.value[q].has_value();
  }
  return errors;
}

struct Done {
  Errors shot;                ///< as the session would read it
  std::vector<Errors> parts;  ///< in the order of kParts; empty if the photograph could not be matched
  reduction::FlagSet flags;
  std::string problem;  ///< what the session would say to a person
};

/// A frame of the images that were found, with what is not in `measured` as it truly is. The stated standard
/// deviations stay, so that everything weighs what it weighs.
class Mixed {
 public:
  Mixed(const KnownPhotograph& known, const Frame& assembled, double true_diameter_m)
      : known_(known), assembled_(assembled), true_diameter_m_(true_diameter_m) {
    for (const Pair& pair : pairs_of(known.truth, assembled.images)) truth_of_.push_back(pair);
    std::ranges::sort(truth_of_, {}, &Pair::image);
  }

  bool empty() const { return truth_of_.empty(); }

  Frame frame(const Sources& measured) const {
    const auto is = [&](Source s) { return measured.test(static_cast<std::size_t>(s)); };
    Frame frame = assembled_;
    if (!is(Source::scale)) frame.px_per_m = known_.scene_truth.px_per_m_of_ball;
    if (!is(Source::ball)) frame.ball_diameter_m = true_diameter_m_;
    if (!is(Source::surface)) put_surface(frame);
    frame.images.clear();
    for (const Pair& pair : truth_of_) {
      reduction::BallImage image = assembled_.images[pair.image];
      const TrueImage& truth = known_.truth[pair.truth];
      if (!is(Source::centres) && truth.leg != Leg::contact) image.centre_px = truth.centre_px;
      if (!is(Source::diameters)) image.diameter_px = truth.diameter_px;
      if (!is(Source::equators) && image.equator_rad) image.equator_rad = truth.equator_rad;
      if (!is(Source::times)) image.time_s = known_.times_s[pair.truth] - known_.times_s[truth_of_[0].truth];
      frame.images.push_back(std::move(image));
    }
    return frame;
  }

 private:
  /// The points where they were along the line, on the true one.
  void put_surface(Frame& frame) const {
    const auto& line = known_.scene_truth.surface_px;
    const double slope = (line[1].y - line[0].y) / (line[1].x - line[0].x);
    for (reduction::PointPx& p : frame.surface_px) p.y = line[0].y + slope * (p.x - line[0].x);
  }

  const KnownPhotograph& known_;
  const Frame& assembled_;
  double true_diameter_m_;
  std::vector<Pair> truth_of_;
};

std::uint64_t hash_of(const std::string& name) {
  std::uint64_t hash = 0xcbf29ce484222325U;  // Fowler, Noll, Vo
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

/// A calibration and a ball that are off by their standard deviations.
Calibrated calibrated(const Options& options, const sim::Scene& scene, double px_per_m, int shot) {
  sim::Draws draws(options.seed ^ hash_of(scene.name), sim::Purpose::tablet,
                   static_cast<std::uint64_t>(shot));
  Calibrated c;
  c.px_per_m = px_per_m * (1.0 + 0.01 * options.scale_sd_percent * draws.normal());
  c.px_per_m_sd = px_per_m * (0.01 * options.scale_sd_percent);
  c.ball_diameter_sd_m = 1e-3 * options.ball_sd_mm;
  c.ball_diameter_m = scene.ball.diameter_m + c.ball_diameter_sd_m * draws.normal();
  return c;
}

std::vector<double> seconds_of(const host::FlashTimes& times) {
  std::vector<double> seconds;
  for (const host::ObservedFlash& flash : times.seen)
    seconds.push_back(to_seconds(flash.time - times.seen.front().time));
  return seconds;
}

Result<Done> run_shot(const Options& options, const Take& take) {
  const auto known = known_photograph(take);
  if (!known) return tl::unexpected(known.error());
  const host::RigFile rig =
      rig_of(take.scene, calibrated(options, take.scene, known->scene_truth.px_per_m_of_ball, take.shot));
  const strobe_msgs::shot_t shot =
      shot_message(*known, take.scene, take.shot, to_ns(known->shot.exposure.closed), take.shooting.period);
  auto settings = host::digitize_settings(rig, known->photograph.width(), known->photograph.height());
  if (!settings) return tl::unexpected(settings.error());
  settings->effort = options.effort;
  settings->flash_times_s = seconds_of(host::flash_times(shot));
  const auto digitized = strobe::digitize::digitize(known->photograph, *settings);
  if (!digitized) return tl::unexpected(digitized.error());
  const strobe_msgs::frame_t frame = messages::frame_to_lcm(digitized->frame);
  const host::AssemblySettings assembly = host::assembly_settings(rig);
  const host::ShotReadout result = host::shot_readout(shot, frame, assembly);
  const bool line = take.scene.ball_appearance.line;
  Done done{errors_of(result.readout, known->shot.truth, line), {}, result.readout.flags, result.problem};
  const host::AssembledShot assembled = host::assemble(shot, frame, assembly);
  const Mixed mixed(*known, assembled.frame, take.scene.ball.diameter_m);
  if (mixed.empty()) return done;
  for (const Part& part : kParts) {
    const auto readout = reduction::reduce(mixed.frame(part.measured), reduction::Estimator::best);
    if (!readout) return done;
    done.parts.push_back(errors_of(*readout, known->shot.truth, line));
  }
  return done;
}

/// What is beyond its tolerance: name, error and stated sd.
std::string words_of(const Errors& errors) {
  std::string words;
  for (std::size_t i = 0; i < kCount; ++i)
    if (!errors.within[i])
      words += fmt::format(" {} {:.3g} (sd {:.2g})", name(kChecked[i]), errors.error[i], errors.sd[i]);
  return words;
}

class Tally {
 public:
  void add(const Errors& errors) {
    ++shots_;
    all_within_ += errors.all_within() ? 1 : 0;
    for (std::size_t i = 0; i < kCount; ++i) {
      within_[i] += errors.within[i] ? 1 : 0;
      if (!std::isfinite(errors.error[i])) continue;
      ++counted_[i];
      squares_[i] += errors.error[i] * errors.error[i];
      if (errors.sd[i] > 0.0) normalized_[i] += std::pow(errors.error[i] / errors.sd[i], 2);
    }
  }
  int shots() const { return shots_; }
  double share_of_all() const { return 100.0 * all_within_ / std::max(1, shots_); }
  double share(std::size_t i) const { return 100.0 * within_[i] / std::max(1, shots_); }
  double rms(std::size_t i) const { return std::sqrt(squares_[i] / counted_[i]); }
  double normalized(std::size_t i) const { return std::sqrt(normalized_[i] / counted_[i]); }

 private:
  int shots_ = 0, all_within_ = 0;
  std::array<int, kCount> within_{}, counted_{};
  std::array<double, kCount> squares_{}, normalized_{};
};

class Study {
 public:
  Study(const Options& options, std::vector<sim::Scene> scenes)
      : options_(options), scenes_(std::move(scenes)) {}

  Result<void> run() {
    const auto shots = static_cast<std::size_t>(options_.shots.value_or(1));
    print_head();
    const auto done = try_in_order(
        scenes_.size() * shots, options_.jobs,
        [&](std::size_t i) {
          const sim::Scene& scene = scenes_[i / shots];
          return run_shot(options_, {.scene = scene,
                                     .seed = options_.seed,
                                     .shot = static_cast<int>(i % shots) + 1,
                                     .kept_in = options_.keep,
                                     .shooting = shooting_of(options_, scene)});
        },
        [&](std::size_t i, const Done& one) {
          const std::string& name = scenes_[i / shots].name;
          const auto note = [&](const std::string& text) {
            problems_.push_back(fmt::format("{} shot {}: {}", name, i % shots + 1, text));
          };
          take(one);
          if (!one.shot.all_within()) note("beyond:" + words_of(one.shot));
          if (!one.problem.empty()) note(one.problem);
          if ((i + 1) % shots == 0) end_scene(name);
        });
    if (!done) return done;
    if (scenes_.size() > 1) print_shares("all", all_);
    print_parts();
    return {};
  }

 private:
  static void print_head() {
    fmt::print(
        "shots of which the readout is within +-.05 m/s, max(1 %, 1.5 rad/s), .003, in percent\n{:<18}"
        " {:>5} {:>6} |",
        "", "shots", "all");
    for (const Quantity q : kChecked) fmt::print(" {:>14}", name(q));
    fmt::print("\n");
  }

  static void print_shares(const std::string& name, const Tally& tally) {
    fmt::print("{:<18} {:>5} {:>6.1f} |", name, tally.shots(), tally.share_of_all());
    for (std::size_t i = 0; i < kCount; ++i) fmt::print(" {:>14.1f}", tally.share(i));
    fmt::print("\n");
    std::fflush(stdout);
  }

  void take(const Done& done) {
    of_scene_.add(done.shot);
    all_.add(done.shot);
    for (std::size_t p = 0; p < done.parts.size(); ++p) parts_[p].add(done.parts[p]);
    if (done.parts.empty()) ++unmatched_;
    for (std::size_t f = 0; f < reduction::kFlagCount; ++f)
      if (done.flags.has(static_cast<reduction::Flag>(f))) ++flagged_[f];
  }

  void end_scene(const std::string& name) {
    print_shares(name, of_scene_);
    of_scene_ = {};
  }

  void print_row(const std::string& name, const std::function<double(std::size_t)>& value) const {
    fmt::print("{:<31} |", name);
    for (std::size_t i = 0; i < kCount; ++i) fmt::print(" {:>14.4f}", value(i));
    fmt::print("\n");
  }

  void print_parts() const {
    fmt::print("\nrms error of the readout where this alone is as measured and all else true:\n{:<31} |", "");
    for (const Quantity q : kChecked) fmt::print(" {:>14}", name(q));
    fmt::print("\n");
    for (std::size_t p = 0; p < kParts.size(); ++p)
      print_row(kParts[p].name, [&](std::size_t i) { return parts_[p].rms(i); });
    print_row("the session's readout", [&](std::size_t i) { return all_.rms(i); });
    print_row("  over its stated sd", [&](std::size_t i) { return all_.normalized(i); });
    fmt::print(
        "\n{} shots, {} without matched images; scale known to {:.3f} %, the ball to {:.2f} mm; flags:",
        all_.shots(), unmatched_, options_.scale_sd_percent, options_.ball_sd_mm);
    for (std::size_t f = 0; f < reduction::kFlagCount; ++f)
      if (flagged_[f] > 0) fmt::print(" {} {}", reduction::kFlagNames[f], flagged_[f]);
    fmt::print("\n");
    for (const std::string& problem : problems_) fmt::print("  {}\n", problem);
  }

  const Options& options_;
  std::vector<sim::Scene> scenes_;
  Tally of_scene_, all_;
  std::array<Tally, kParts.size()> parts_;
  std::array<int, reduction::kFlagCount> flagged_{};
  int unmatched_ = 0;
  std::vector<std::string> problems_;
};

}  // namespace

Result<void> study_chain(const Options& options) {
  auto names = scene_names(options.scenes);
  if (!names) return tl::unexpected(names.error());
  if (options.scenes.empty()) names->insert(names->begin(), "itf_pace_medium");
  auto scenes = scenes_of(options, *names);
  if (!scenes) return tl::unexpected(scenes.error());
  return Study(options, std::move(*scenes)).run();
}

}  // namespace strobe::studies::digitize
