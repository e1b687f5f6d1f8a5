// strobe-bench digitize: rendered photographs digitized, held against the truth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "common/config/files.hpp"
#include "host/assembly/coded_spacing.hpp"
#include "host/config/rig_file.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/studies/digitize/studies.hpp"

namespace {

using namespace strobe;
using namespace strobe::studies::digitize;

/// Which study, and what is asked of it.
struct Request {
  bool robustness = false, chain = false, latency = false, matches = false, raw = false;
  std::string plan, effort = "standard", renderer = "sim";
  Options options;
};

/// Of a plan file, or of the shipped rig file.
Result<std::vector<Duration>> planned_train(const std::string& plan_file) {
  const auto rig = host::load_rig("");
  if (!rig) return tl::unexpected(rig.error());
  host::PlanFile plan = rig->plan;
  if (!plan_file.empty()) {
    const auto text = config::read_file(plan_file);
    if (!text) return tl::unexpected(text.error());
    const auto read = host::read_plan(*text, plan_file, plan);
    if (!read) return tl::unexpected(read.error());
    plan = *read;
  }
  const ShotPlan shot = host::spaced_plan(plan, *rig, true).plan.shot();
  std::vector<Duration> train;
  for (const CodedFlash& flash : shot.code) train.push_back(flash.offset);
  if (shot.code.empty())
    for (Duration at{}; at < shot.exposure; at += shot.period) train.push_back(at);
  return train;
}

int run(Request& request) {
  if (request.robustness + request.chain + request.latency + request.matches + request.raw > 1) {
    fmt::print(stderr,
               "strobe-bench: digitize: --robustness, --chain, --latency, --matches and --raw exclude each other\n");
    return 2;
  }
  request.options.independent = request.renderer == "independent";
  if (request.options.independent && (request.chain || request.latency || request.raw)) {
    fmt::print(stderr,
               "strobe-bench: digitize: --renderer independent is for the accuracy, --matches and --robustness\n");
    return 2;
  }
  if (request.matches) {
    auto train = planned_train(request.plan);
    if (!train) {
      fmt::print(stderr, "strobe-bench: {}\n", train.error().message);
      return 2;
    }
    request.options.train = std::move(*train);
  }
  request.options.effort = strobe::digitize::effort_from_name(request.effort).value();
  // Photographs side by side: threads within one only get in each other's way.
  if (request.options.jobs > 1) cv::setNumThreads(1);
  const auto study = request.robustness ? study_robustness
                     : request.chain    ? study_chain
                     : request.latency  ? study_latency
                     : request.matches  ? study_matches
                     : request.raw      ? study_raw
                                        : study_accuracy;
  const auto done = study(request.options);
  if (done) return 0;
  fmt::print(stderr, "strobe-bench: {}\n", done.error().message);
  return 1;
}

void add_studies(CLI::App& command, Request& o) {
  command.add_flag("--robustness", o.robustness,
                   "How far conditions may go until it breaks, one at a time (--axis, --csv), and how true the images' "
                   "probabilities are");
  command.add_flag("--chain", o.chain,
                   "Readouts held against the truth, and what scale, stamps, centres ... contribute");
  command.add_flag("--latency", o.latency,
                   "Time from a photograph's arrival to the readout, as in strobe live (--shots: in all)");
  command.add_flag("--matches", o.matches,
                   "Which flash made which image: shots rejected and flagged, errors over stated sds, shots "
                   "with wrong numbers and no flag");
  command.add_flag("--raw", o.raw,
                   "A colour sensor's mosaic, and the same demosaiced as a JPEG, beside a grey sensor's "
                   "photograph; needs dcraw_emu (libraw-bin)");
  command.add_option("--noise", o.options.noise, "Of --raw: of the sensors, over the scenes'")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 20.0));
  command.add_flag("--simulated", o.options.simulated,
                   "Of --matches: nothing is rendered, a normal error stands for the digitizer's");
  command.add_option("--plan", o.plan, "Of --matches: plan file, TOML (default: the shipped rig file's)");
  command.add_option("--flash-time-sd-us", o.options.flash_time_sd_us, "Of --matches: as in the rig file")
      ->check(CLI::Range(0.01, 100.0));
  command.add_option("--machine-lag-sd-ms", o.options.machine_lag_sd_ms, "Likewise")
      ->check(CLI::Range(0.01, 1000.0));
  command.add_flag("!--unknown-lens", o.options.viewpoint,
                   "Of --matches: where the lens is, is not in the rig file");
  command
      .add_option("--issue-jitter-us", o.options.issue_jitter_us,
                  "Of --matches: by how much flashes come late")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1000.0));
}

void add_what(CLI::App& command, Request& request) {
  Options& o = request.options;
  command.add_option("scenes", o.scenes, "Scenes; without, the thesis's 21 conditions");
  command.add_option("--shots", o.shots, "Photographs of each [1; robustness 2; latency 21 in all]")
      ->check(CLI::Range(1, 100000));
  command.add_option("--first-shot", o.first_shot, "The accuracy's first shot of each scene")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  command.add_option("--seed", o.seed, "Of the simulation")->capture_default_str();
  command.add_option("--effort", request.effort, "fast, standard or thorough")
      ->check(CLI::IsMember({"fast", "standard", "thorough"}))
      ->capture_default_str();
  command
      .add_option("--renderer", request.renderer,
                  "Whose photographs: sim's, or an independent one's that shares no code")
      ->check(CLI::IsMember({"sim", "independent"}))
      ->capture_default_str();
  command.add_option("--ball", o.ball,
                     "Of the accuracy, --robustness and --chain: scene whose ball it is, images where a tennis ball's were");
  command.add_flag("--draw-line", o.draw_line, "Of --ball: with a line, whatever its scene says");
  command.add_flag("--ignore-marking", o.ignore_marking,
                   "Of the accuracy: a line is looked for on balls that have none, too (false)");
  command.add_option("--axis", o.axes, "Of the robustness; without, all");
  command.add_option("--scale-sd-percent", o.scale_sd_percent, "Of the chain's calibrated scale")
      ->capture_default_str()
      ->check(CLI::Range(0.0001, 10.0));
  command
      .add_option("--ball-sd-mm", o.ball_sd_mm,
                  "By how much the chain's ball differs from the diameter that is given")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 5.0));
}

void add_how(CLI::App& command, Options& o) {
  command.add_option("--rounds", o.rounds, "Digitized so often; the least time counts")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command.add_option("--jobs", o.jobs, "Photographs at a time; with more than one no times are shown")
      ->capture_default_str()
      ->check(CLI::Range(1, 256));
  command.add_option("--save", o.save,
                     "Folder for photographs with images missed or invented, and what was digitized on them");
  command.add_option(
      "--keep", o.keep,
      "Folder for all photographs: those rendered there before are read instead of rendered again");
  command.add_option("--csv", o.csv, "One line an image; with --robustness one line a condition");
}

}  // namespace

namespace strobe::studies {

void add_digitize_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Request>();
  CLI::App* command =
      app.add_subcommand("digitize", "Rendered photographs digitized, held against the truth");
  command->footer(
      "By scene: images found of those there, in the air and in contact; of the others those that were said "
      "to\n"
      "be unmeasurable (said); invented ones; those cut off by the border; rms errors of centre [px], "
      "diameter "
      "[px],\n"
      "equator [degrees; false: told of a ball that has no line], the line's tilt [degrees, away from the\n"
      "diameter positive], contact top and width, surface [px], the same "
      "over the stated standard deviations "
      "(1: they "
      "are\n"
      "true), the largest; and how many are off by more than 5 stated sd. Times are the least of the "
      "rounds.\n"
      "Examples: strobe-bench digitize --shots 5 --effort standard --save /tmp/amiss\n"
      "          strobe-bench digitize --robustness --jobs 2 --csv curves.csv\n"
      "          strobe-bench digitize --chain itf_pace_medium --shots 100 --jobs 2\n"
      "          strobe-bench digitize --latency --rounds 3");
  add_studies(*command, *options);
  add_what(*command, *options);
  add_how(*command, options->options);
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::studies
