// strobe-bench light: what the light advice says of rendered photographs, sound ones and such with one fault,
// from slight to gross.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "host/light/advice.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/studies/digitize/in_order.hpp"
#include "tests/studies/digitize/photographs.hpp"
#include "tests/studies/digitize/studies.hpp"

namespace {

using namespace strobe;
using light::Advice;
using light::Verdict;
using studies::digitize::Take;

struct Options {
  std::vector<std::string> scenes, axes;
  int shots = 1, jobs = 1;
  std::uint64_t seed = 1;
  bool measures = false;
  std::string renderer = "sim";
};

/// One strength of one fault.
struct Condition {
  std::string axis;
  double value = 0.0;
  std::function<void(Take&, double)> apply;
};

std::vector<Condition> conditions() {
  std::vector<Condition> all;
  const auto add = [&](const char* axis, std::initializer_list<double> values, auto&& apply) {
    for (const double value : values) all.push_back({axis, value, apply});
  };
  add("sound", {0}, [](Take&, double) {});
  add("bits", {12, 16}, [](Take& t, double v) { t.scene.photograph.bits = static_cast<int>(v); });
  add("exposure", {0.03, 0.0625, 0.125, 0.25, 0.35, 0.5, 0.7, 1.4, 2, 3, 6},
      [](Take& t, double v) { t.scene.photograph.exposure = v; });
  add("blur", {1.2, 1.5, 2, 3, 5}, [](Take& t, double v) { t.scene.photograph.blur_px = v; });
  add("defocus", {1, 2, 3, 4, 6, 9}, [](Take& t, double v) { t.scene.photograph.defocus_px = v; });
  add("ambient", {0.02, 0.05, 0.1, 0.2, 0.4}, [](Take& t, double v) { t.scene.photograph.ambient = v; });
  add("gamma", {0.9, 0.8, 0.6, 0.45}, [](Take& t, double v) { t.scene.photograph.gamma = v; });
  add("black", {0}, [](Take& t, double v) {
    t.scene.photograph.black_level = v;
    t.scene.background.wall = 0.0;
  });
  add("flash_us", {10, 30, 50, 100, 200}, [](Take& t, double v) { t.scene.lamps.flash_s = 1e-6 * v; });
  add("lamp_a", {0.7, 0.5, 0.3, 0.1, 0}, [](Take& t, double v) { t.scene.photograph.lamp_a_power = v; });
  add("lamp_b", {0.7, 0.5, 0.3, 0.1, 0}, [](Take& t, double v) { t.scene.photograph.lamp_b_power = v; });
  add("one_misses", {-3, 2}, [](Take& t, double v) {
    sim::Fault fault;
    fault.kind = sim::FaultKind::flash_missing;
    fault.flash_from_impact = static_cast<int>(v);
    fault.lamp_a = false;
    t.scene.faults.push_back(fault);
  });
  // Images that leave the ball's way free, as room light does not show elsewhere.
  add("room", {0, 0.02, 0.05, 0.1, 0.2, 0.4}, [](Take& t, double) { t.shooting.period = milliseconds(6); });
  add("noise", {2, 4, 8}, [](Take& t, double v) {
    t.scene.photograph.full_well_e /= v * v;
    t.scene.photograph.read_noise_e /= v;
  });
  return all;
}

struct Told {
  light::LightMeasures measures;
  std::vector<Advice> advice;
};

/// Room lamps that flicker every 0.6 ms and light the middle of the ball's way by that share of a flash's
/// light on the ball, added to the photograph.
Result<void> add_room_light(const Take& take, double share, digitize::Photograph& photograph) {
  constexpr double kPeriod_s = 0.6e-3;
  Take room = take;
  room.shooting.period = from_seconds(kPeriod_s);
  room.scene.lamps.recharge_s = 0.0;
  room.scene.photograph.exposure *=
      share * kPeriod_s * take.scene.machine.speed_mps / take.scene.ball.diameter_m;
  const auto lit = studies::digitize::known_photograph(room);
  if (!lit) return tl::unexpected(lit.error());
  photograph.intensity += lit->photograph.intensity - take.scene.photograph.black_level;
  cv::min(photograph.intensity, photograph.saturation, photograph.intensity);
  cv::max(photograph.intensity, 0.0, photograph.intensity);
  return {};
}

Result<Told> told_of(const Take& take, double room) {
  auto known = studies::digitize::known_photograph(take);
  if (!known) return tl::unexpected(known.error());
  if (room > 0.0)
    if (const auto added = add_room_light(take, room, known->photograph); !added)
      return tl::unexpected(added.error());
  const auto found = digitize::digitize(known->photograph, known->settings);
  if (!found) return tl::unexpected(found.error());
  Told told{light::measure_light(known->photograph, known->settings.map, *found), {}};
  told.advice = light::advise(told.measures);
  return told;
}

void print_measures(const Take& take, const light::LightMeasures& m) {
  fmt::print(
      "  {:<10} {:>2} images  bright {:.2f} dark {:.3f} clip {:.4f} ({:.4f} {:.4f}) felt {:.3f} weakest "
      "{:.2f}"
      " limbs {:.3f} {:.3f} bg {:.3f} noise {:.4f} rise {:.3f} ({:.0f} sds) black {:.2f} blur {:.2f} ({:.2f} "
      "{:.2f} ± "
      "{:.2f})"
      " smear {:.2f} (at least {:.2f}) transfer {:.2f} ambient {:.3f}\n",
      take.scene.name, m.images, m.bright, m.dark, m.clipped_share, m.clipped.left, m.clipped.right, m.felt,
      m.weakest, m.limbs ? m.limbs->left : 0.0, m.limbs ? m.limbs->right : 0.0, m.background, m.noise,
      m.limb_rise, m.limb_rise / std::max(m.noise, 1e-9), m.black_share, m.blur_px,
      m.blur_at_px ? m.blur_at_px->left : 0.0, m.blur_at_px ? m.blur_at_px->right : 0.0, m.blur_at_sd_px,
      m.smear_px.value_or(-1.0), m.smear_least_px, m.transfer ? m.transfer->exponent : 0.0,
      m.ambient.value_or(-1.0));
}

Result<void> study(const Options& options) {
  const auto names = studies::digitize::scene_names(options.scenes);
  if (!names) return tl::unexpected(names.error());
  const auto scenes = studies::digitize::load_scenes(*names);
  if (!scenes) return tl::unexpected(scenes.error());
  for (const Condition& condition : conditions()) {
    if (!options.axes.empty() && std::ranges::find(options.axes, condition.axis) == options.axes.end())
      continue;
    std::vector<Take> takes;
    for (const sim::Scene& scene : *scenes) {
      for (int shot = 1; shot <= options.shots; ++shot) {
        Take take{.scene = scene, .seed = options.seed, .shot = shot};
        take.independent = options.renderer == "independent";
        if (take.independent) take.jpeg_quality = 0;
        condition.apply(take, condition.value);
        takes.push_back(std::move(take));
      }
    }
    int silent = 0;
    std::map<std::string, int> said;
    const auto done = studies::digitize::try_in_order(
        takes.size(), options.jobs,
        [&](std::size_t i) { return told_of(takes[i], condition.axis == "room" ? condition.value : 0.0); },
        [&](std::size_t i, const Told& told) {
          silent += light::worst(told.advice) == Verdict::ok ? 1 : 0;
          for (const Advice& a : told.advice)
            if (a.verdict != Verdict::ok) ++said[fmt::format("{} {}", a.what, light::name(a.verdict))];
          if (options.measures) print_measures(takes[i], told.measures);
        });
    if (!done) return done;
    std::vector<std::string> words;
    for (const auto& [what, count] : said) words.push_back(fmt::format("{} {}", what, count));
    fmt::print("{:<10} {:>7g}  {:>4} photographs, {:>4} of which nothing is said; {}\n", condition.axis,
               condition.value, takes.size(), silent, fmt::join(words, ", "));
    std::fflush(stdout);
  }
  return {};
}

}  // namespace

namespace strobe::studies {

void add_light_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("light", "What the light advice says of rendered photographs");
  command->footer(
      "Of each strength of each fault: of how many photographs nothing is said, and what of the others.\n"
      "Example: strobe-bench light --shots 3 --axis sound --jobs 2");
  command->add_option("scenes", options->scenes, "Scenes; without, the thesis's 21 conditions");
  command->add_option("--shots", options->shots, "Photographs of each")->check(CLI::Range(1, 100000));
  command->add_option("--seed", options->seed, "Of the simulation")->capture_default_str();
  command->add_option("--axis", options->axes, "Faults; without, all");
  command->add_option("--renderer", options->renderer, "sim's, or the independent one's")
      ->check(CLI::IsMember({"sim", "independent"}))
      ->capture_default_str();
  command->add_option("--jobs", options->jobs, "Photographs at a time")
      ->capture_default_str()
      ->check(CLI::Range(1, 256));
  command->add_flag("--measures", options->measures, "The numbers of each photograph, too");
  command->callback([options, &exit_status] {
    if (options->jobs > 1) cv::setNumThreads(1);
    const auto done = study(*options);
    if (!done) fmt::print(stderr, "strobe-bench: {}\n", done.error().message);
    exit_status = done ? 0 : 1;
  });
}

}  // namespace strobe::studies
