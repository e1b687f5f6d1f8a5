// strobe-bench series-coverage: how often the 95 % intervals of `strobe series` hold the truth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "sim/loading/load_scene.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/studies/series/study.hpp"

namespace {

using namespace strobe::studies;
using strobe::reduction::kQuantityCount;
using strobe::reduction::kQuantityNames;

struct Options {
  SeriesPlan plan;
  std::vector<std::string> conditions{"zero_17", "zero_23", "zero_34", "zero_41", "zero_49", "zero_60",
                                      "zero_68", "top_18",  "top_23",  "top_34",  "top_42",  "top_48",
                                      "top_61",  "top_71",  "back_17", "back_22", "back_35", "back_40",
                                      "back_45", "back_59", "back_68"};
  double scale_sd_percent = 0.3, ball_diameter_sd_mm = 0.3;
  bool json = false;
};

/// Shows how far the study is until it goes out of scope.
class Progress {
 public:
  explicit Progress(int pairs)
      : pairs_(pairs), thread_([this](const std::stop_token& stop) {
          for (int tick = 0; !stop.stop_requested(); ++tick) {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            if (tick % 20 == 19) fmt::print(stderr, "\r{} of {} pairs of series ", done.load(), pairs_);
          }
          fmt::print(stderr, "\r{:40}\r", "");
        }) {}

  std::atomic<int> done = 0;

 private:
  int pairs_;
  std::jthread thread_;
};

void report(const Options& options, const SeriesCoverage& coverage) {
  const auto row = [&](std::string_view name, const Held& means, const Held& differences,
                       const Held& scatter) {
    if (means.intervals == 0) return;
    const double shared = means.shared / means.intervals;
    const double left = differences.intervals > 0 ? differences.shared / differences.intervals : 0.0;
    if (options.json) {
      const nlohmann::ordered_json line{{"quantity", name},
                                        {"intervals", means.intervals},
                                        {"hold", means.share()},
                                        {"shared_share", shared},
                                        {"hold_by_scatter_alone", scatter.share()},
                                        {"differences", differences.intervals},
                                        {"differences_hold", differences.share()},
                                        {"differences_shared_share", left}};
      fmt::print("{}\n", line.dump());
      return;
    }
    fmt::print("{:<18}{:>10}{:>8.3f}{:>10.2f}{:>15.3f}{:>13}{:>8.3f}{:>10.2f}\n", name, means.intervals,
               means.share(), shared, scatter.share(), differences.intervals, differences.share(), left);
  };
  if (!options.json)
    fmt::print(
        "{} series of {} shots, seed {}; scale known to {} %, ball to {} mm; {} shots rejected\n"
        "{:<18}{:>10}{:>8}{:>10}{:>15}{:>13}{:>8}{:>10}\n",
        options.plan.series, options.plan.shots, options.plan.seed, options.scale_sd_percent,
        options.ball_diameter_sd_mm, coverage.rejected, "", "means", "hold", "shared", "scatter alone",
        "differences", "hold", "shared");
  Held means, differences, scatter;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    row(kQuantityNames[i], coverage.means[i], coverage.differences[i], coverage.by_scatter[i]);
    means.add(coverage.means[i]);
    differences.add(coverage.differences[i]);
    scatter.add(coverage.by_scatter[i]);
  }
  row("all", means, differences, scatter);
}

int series_coverage(Options options) {
  for (const std::string& name : options.conditions) {
    auto scene = strobe::sim::load_scene(name);
    if (!scene) {
      fmt::print(stderr, "strobe-bench: {}\n", scene.error().message);
      return 2;
    }
    options.plan.scenes.push_back(std::move(*scene));
  }
  options.plan.scale_sd = 1e-2 * options.scale_sd_percent;
  options.plan.ball_diameter_sd_m = 1e-3 * options.ball_diameter_sd_mm;
  SeriesCoverage coverage;
  {
    Progress progress(options.plan.series / 2);
    coverage = run(options.plan, progress.done);
  }
  report(options, coverage);
  return 0;
}

}  // namespace

namespace strobe::studies {

void add_series_coverage_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("series-coverage",
                                         "how often the 95 % intervals of series' means, and of differences "
                                         "of two series that share a calibration, "
                                         "hold the truth.\nScale, ball, drag and spin decay are wrong by "
                                         "draws of their sds, the same in both series "
                                         "of a pair; every second pair has no calibrated scale.\nExample: "
                                         "strobe-bench series-coverage --series 2000");
  command->add_option("--series", options->plan.series, "in pairs")
      ->check(CLI::Range(2, 10000000))
      ->capture_default_str();
  command->add_option("--shots", options->plan.shots, "that count, of each")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  command
      ->add_option("--conditions", options->conditions,
                   "scenes, two or more; a pair's series are of neighbours (default: the thesis's 21)")
      ->delimiter(',');
  command->add_option("--scale-sd-percent", options->scale_sd_percent, "of the calibration")
      ->check(CLI::Range(1e-3, 10.0))
      ->capture_default_str();
  command->add_option("--ball-sd-mm", options->ball_diameter_sd_mm, "of the ball's diameter")
      ->check(CLI::Range(1e-3, 5.0))
      ->capture_default_str();
  command->add_option("--seed", options->plan.seed, "repeats a run, with any number of threads")
      ->capture_default_str();
  command->add_option("--threads", options->plan.threads, "run in parallel")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one object per quantity, and one of all");
  command->callback([options, &exit_status] { exit_status = series_coverage(*options); });
}

}  // namespace strobe::studies
