// strobe-bench series-coverage: how often the 95 % intervals of `strobe series` hold the truth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "sim/loading/load_scene.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/studies/series/how_many.hpp"
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
  bool how_many = false, json = false;
};

constexpr int kPairs = 4000;  ///< of each case of power

/// Shows how far the study is until it goes out of scope.
class Progress {
 public:
  explicit Progress(int pairs)
      : pairs_(pairs), thread_([this](const std::stop_token& stop) {
          for (int tick = 0; !stop.stop_requested(); ++tick) {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            if (tick % 20 == 19) fmt::print(stderr, "\r{} of {} ", done.load(), pairs_);
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

void report_computed(const Options& options) {
  if (!options.json)
    fmt::print("series that end as soon as their mean is known, computed; half width in sds of the scatter\n"
               "{:>12}{:>16}{:>12}{:>12}{:>12}{:>16}\n",
               "half width", "if sd is known", "mean shots", "end at 5", "coverage", "by Student's t");
  for (double shots = 1.0; shots < 120.0; shots *= 1.25) {
    const SequentialCoverage c = sequential_coverage(1.959964 / std::sqrt(shots));
    if (options.json) {
      const nlohmann::ordered_json line{{"half_width", c.half_width}, {"shots_if_known", c.known_shots},
                                        {"mean_shots", c.mean_shots}, {"end_at_first", c.ends_at_first},
                                        {"coverage", c.coverage},     {"coverage_by_student", c.plain_coverage}};
      fmt::print("{}\n", line.dump());
      continue;
    }
    fmt::print("{:>12.3f}{:>16.1f}{:>12.1f}{:>12.4f}{:>12.4f}{:>16.4f}\n", c.half_width, c.known_shots, c.mean_shots,
               c.ends_at_first, c.coverage, c.plain_coverage);
  }
}

void report_simulated(const Options& options, std::size_t which, const SequentialSeries& s) {
  const int ended = s.sequential.intervals;
  const double shots = ended > 0 ? s.shots / ended : 0.0, shared = ended > 0 ? s.sequential.shared / ended : 0.0;
  if (options.json) {
    const nlohmann::ordered_json line{{"shots_if_known", kShotsIfKnown[which]}, {"series", ended},
                                      {"not_known", s.not_known},               {"mean_shots", shots},
                                      {"hold", s.sequential.share()},           {"hold_by_student", s.plain.share()},
                                      {"shared_share", shared}};
    fmt::print("{}\n", line.dump());
    return;
  }
  fmt::print("{:>16.0f}{:>10}{:>12}{:>12.1f}{:>10.4f}{:>16.4f}{:>10.2f}\n", kShotsIfKnown[which], ended, s.not_known,
             shots, s.sequential.share(), s.plain.share(), shared);
}

void report_power(const Options& options) {
  if (!options.json)
    fmt::print("pairs of {} series: asked for, and found by so many shots of each\n"
               "{:>8}{:>8}{:>8}{:>12}{:>8}{:>8}{:>10}{:>8}\n",
               kPairs, "sd", "sd", "shared", "difference", "asked", "shots", "promised", "found");
  for (const PowerCase& c : run_power(kPairs, options.plan.seed)) {
    if (options.json) {
      const nlohmann::ordered_json line{{"sds", {c.first_sd, c.second_sd}}, {"shared_sd", c.shared_sd},
                                        {"difference", c.difference},       {"asked", c.asked},
                                        {"shots", c.shots},                 {"promised", c.promised},
                                        {"found", c.found}};
      fmt::print("{}\n", line.dump());
      continue;
    }
    fmt::print("{:>8}{:>8}{:>8}{:>12}{:>8}{:>8}{:>10.3f}{:>8.3f}\n", c.first_sd, c.second_sd, c.shared_sd,
               c.difference, c.asked, c.shots, c.promised, c.found);
  }
}

void how_many(const Options& options) {
  report_computed(options);
  std::array<SequentialSeries, kShotsIfKnown.size()> all;
  {
    Progress progress(options.plan.series);
    all = run_sequential(options.plan, progress.done);
  }
  if (!options.json)
    fmt::print("the same by {} series of simulated shots\n{:>16}{:>10}{:>12}{:>12}{:>10}{:>16}{:>10}\n",
               options.plan.series, "if sd is known", "series", "not known", "mean shots", "hold", "by Student's t",
               "shared");
  for (std::size_t i = 0; i < all.size(); ++i) report_simulated(options, i, all[i]);
  report_power(options);
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
  if (options.how_many) {
    how_many(options);
    return 0;
  }
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
  command->add_flag("--how-many", options->how_many,
                    "instead: series that end as soon as a mean is known well enough (--series of them), computed and "
                    "simulated, and the power of as many shots as were told");
  command->add_flag("--json", options->json, "one object per quantity, and one of all");
  command->callback([options, &exit_status] { exit_status = series_coverage(*options); });
}

}  // namespace strobe::studies
