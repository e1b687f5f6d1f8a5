// strobe-bench drift: how soon a drift is told, its cause, and how often sound shots alarm.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "sim/loading/load_scene.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/studies/drift/study.hpp"

namespace {

using namespace strobe::studies;
using strobe::host::kWitnessCount;
using strobe::host::kWitnessNames;

struct Options {
  DriftPlan plan;
  std::vector<std::string> conditions{"zero_17", "zero_23", "zero_34", "zero_41", "zero_49", "zero_60",
                                      "zero_68", "top_18",  "top_23",  "top_34",  "top_42",  "top_48",
                                      "top_61",  "top_71",  "back_17", "back_22", "back_35", "back_40",
                                      "back_45", "back_59", "back_68"};
  bool hand = false, json = false;
};

/// So many shots tell this share of the runs; 0: not within those that were fired.
int shots_of(const DriftTold& told, double share) {
  const auto runs = static_cast<double>(told.runs - told.early);
  const auto rank = static_cast<std::size_t>(std::ceil(share * runs));
  return rank >= 1 && rank <= told.shots.size() ? told.shots[rank - 1] : 0;
}

std::string by_charts(const std::array<int, kWitnessCount>& counts) {
  std::string text;
  for (std::size_t i = 0; i < kWitnessCount; ++i)
    if (counts[i] > 0) text += fmt::format(" {} {}", kWitnessNames[i], counts[i]);
  return text;
}

void report(const Options& options, const DriftStudy& study) {
  if (!options.json)
    fmt::print("{:<8}{:>6}{:>7}{:>8}{:>6}{:>9}{:>8}{:>8}{:>8}  told by\n", "drift", "runs", "told", "median",
               "95 %", "longest", "right", "later", "among");
  for (std::size_t k = 0; k < study.told.size(); ++k) {
    const DriftTold& told = study.told[k];
    const auto n = static_cast<double>(std::max<std::size_t>(told.shots.size(), 1));
    const auto percent = [&](int count) { return 100.0 * count / n; };
    if (options.json) {
      const nlohmann::ordered_json line{{"drift", kDriftKindNames[k]},
                                        {"runs", told.runs - told.early},
                                        {"told", told.shots.size()},
                                        {"median", shots_of(told, 0.5)},
                                        {"shots_95", shots_of(told, 0.95)},
                                        {"longest", shots_of(told, 1.0)},
                                        {"right_percent", percent(told.right)},
                                        {"right_later_percent", percent(told.right_later)},
                                        {"among_percent", percent(told.among)}};
      fmt::print("{}\n", line.dump());
      continue;
    }
    fmt::print("{:<8}{:>6}{:>7}{:>8}{:>6}{:>9}{:>7.1f}%{:>7.1f}%{:>7.1f}% {}\n", kDriftKindNames[k],
               told.runs - told.early, told.shots.size(), shots_of(told, 0.5), shots_of(told, 0.95),
               shots_of(told, 1.0), percent(told.right), percent(told.right_later), percent(told.among),
               by_charts(told.told_by));
  }
  const double shots = static_cast<double>(study.sound) / std::max(study.false_alarms, 1);
  if (options.json) {
    const nlohmann::ordered_json line{
        {"sound", study.sound}, {"false_alarms", study.false_alarms}, {"shots_per_false_alarm", shots}};
    fmt::print("{}\n", line.dump());
    return;
  }
  fmt::print("{} sound shots, {} false alarms, one in {:.0f}:{}\n", study.sound, study.false_alarms, shots,
             by_charts(study.false_by));
}

int drift(Options options) {
  for (const std::string& name : options.conditions) {
    auto scene = strobe::sim::load_scene(name);
    if (!scene) {
      fmt::print(stderr, "strobe-bench: {}\n", scene.error().message);
      return 2;
    }
    options.plan.scenes.push_back(std::move(*scene));
  }
  if (options.hand) options.plan.noise = {.centre_px = 1.5, .diameter_px = 2.0, .equator_rad = 0.0175};
  std::atomic<int> done = 0;
  std::jthread progress([&](const std::stop_token& stop) {
    const int total = total_runs(options.plan);
    for (int tick = 0; !stop.stop_requested(); ++tick) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      if (tick % 20 == 19) fmt::print(stderr, "\r{} of {} runs ", done.load(), total);
    }
    fmt::print(stderr, "\r{:40}\r", "");
  });
  const DriftStudy study = run(options.plan, done);
  progress.request_stop();
  progress.join();
  report(options, study);
  return 0;
}

}  // namespace

namespace strobe::studies {

void add_drift_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("drift",
                         "how many shots tell that scale, clock, tilt or a lamp has changed, what is named as its "
                         "cause, and how often sound shots alarm.\nExample: strobe-bench drift --runs 5 --hand");
  command->add_option("--conditions", options->conditions, "scenes (default: the thesis's 21)")->delimiter(',');
  command->add_option("--runs", options->plan.runs, "of each drift and condition")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--sound", options->plan.sound, "shots in all of which nothing changes")
      ->check(CLI::Range(0, 100000000))
      ->capture_default_str();
  command->add_option("--before", options->plan.before, "sound shots before each drift")
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  command->add_option("--after", options->plan.after, "shots with the drift, at most")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_flag("--hand", options->hand, "noise of a person: 1.5 px in centres, 2 px in diameters");
  command->add_option("--seed", options->plan.seed, "repeats a run, with any number of threads")
      ->capture_default_str();
  command->add_option("--threads", options->plan.threads, "run in parallel")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one object per drift, and one of sound shots");
  command->callback([options, &exit_status] { exit_status = drift(*options); });
}

}  // namespace strobe::studies
