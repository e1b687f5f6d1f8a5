// strobe-bench timing: lateness of the shipped loop's flashes beside cyclictest's, interleaved in one run,
// under loads.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "tests/bench/command.hpp"
#include "tests/bench/timing/cyclictest.hpp"
#include "tests/bench/timing/exceedance_plot.hpp"
#include "tests/bench/timing/load.hpp"
#include "tests/bench/timing/loop_run.hpp"
#include "tests/bench/timing/programs.hpp"
#include "tests/bench/timing/table.hpp"

namespace strobe::bench::timing {

namespace {

struct Options {
  int rounds = 3;
  LoopSettings loop;
  std::vector<std::string> loads = kLoads;
  bool programs = false;
  bool compare = false;
  bool json = false;
  std::string csv;
  std::string plot;
};

/// What is measured in turns; the first is what the ratios are of, the second what they are to.
struct Part {
  std::string name;
  std::vector<Sample> samples;
  double cpu_percent = -1.0;
};

constexpr const char* kLoop = "loop";
constexpr const char* kCyclictest = "cyclictest";

class LoadStudy {
 public:
  LoadStudy(std::string load, const Options& options, std::filesystem::path folder)
      : load_(std::move(load)), options_(options), folder_(std::move(folder)) {}

  void run() {
    Witness witness(options_.loop.priority - 10);
    for (int round = 1; round <= options_.rounds; ++round) {
      const Load load(load_, folder_);
      std::fprintf(stderr, "%s, round %d of %d\n", load_.c_str(), round, options_.rounds);
      take(kLoop, loop(true, Outputs::chip, true));
      append(part(kCyclictest).samples, run_cyclictest(options_.loop));
      if (options_.compare) {
        take("loop, starts anywhere", loop(true, Outputs::chip, false));
        take("loop, no rig on the chip", loop(false, Outputs::chip, true));
        take("loop, sets nothing", loop(false, Outputs::none, true));
      }
      if (options_.programs) take("all programs", run_programs(options_.loop, folder_));
    }
    freezes_ = witness.stop();
  }

  std::vector<Row> rows() const {
    std::vector<Row> rows;
    for (const bool left_out : {true, false}) {
      const Percentiles yardstick = percentiles(values(parts_[1], left_out));
      for (const Part& each : parts_) {
        Row row{load_,
                each.name,
                left_out ? "left out" : "included",
                percentiles(values(each, left_out)),
                each.cpu_percent,
                ""};
        if (each.name != kCyclictest) row.ratio = ratios(row.lateness, yardstick);
        rows.push_back(row);
      }
      if (left_out && options_.compare) {
        for (const auto& [name, samples] : calls_)
          rows.push_back(
              {load_, name + ": the call", "left out", percentiles(outside(samples, freezes_)), -1.0, ""});
      }
    }
    return rows;
  }

  Panel panel() const {
    Panel panel{
        load_ + ", freezes left out", "lateness [us]", "share of wake-ups that are later", true, true, {}};
    for (const Part& each : parts_) panel.curves.push_back(exceedance(each.name, values(each, true)));
    return panel;
  }

  std::string freezes_in_words() const {
    Duration sum;
    Duration longest;
    for (const Freeze& freeze : freezes_) {
      sum = sum + (freeze.end - freeze.begin);
      longest = std::max(longest, freeze.end - freeze.begin);
    }
    return load_ + ": " + std::to_string(freezes_.size()) + " freezes of a core, " +
           std::to_string(sum.ns / 1'000'000) + " ms in all, longest " +
           std::to_string(longest.ns / 1'000'000) + " ms; " + std::to_string(shots_) + " shots, " +
           std::to_string(aborted_) + " aborted by one";
  }

 private:
  Part& part(const std::string& name) {
    for (Part& each : parts_) {
      if (each.name == name) return each;
    }
    return parts_.emplace_back(Part{name, {}, -1.0});
  }
  LoopRun loop(bool rig_waits, Outputs outputs, bool quiet_start) {
    LoopSettings settings = options_.loop;
    settings.outputs = outputs;
    settings.quiet_start = quiet_start;
    return LoopBench(rig_waits).run(settings);
  }
  void take(const std::string& name, const LoopRun& run) {
    Part& taken = part(name);
    append(taken.samples, run.issue);
    if (run.cpu_percent > 0.0) taken.cpu_percent = run.cpu_percent;
    append(calls_[name], run.call);
    shots_ += run.shots;
    aborted_ += run.aborted;
  }
  std::vector<double> values(const Part& each, bool left_out) const {
    return left_out ? outside(each.samples, freezes_) : latenesses(each.samples);
  }

  std::string load_;
  const Options& options_;
  std::filesystem::path folder_;
  std::vector<Part> parts_;
  std::map<std::string, std::vector<Sample>> calls_;
  std::vector<Freeze> freezes_;
  int shots_ = 0;
  int aborted_ = 0;
};

int run_timing(const Options& options) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("strobe-bench-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::vector<Row> rows;
  std::vector<Panel> panels;
  for (const std::string& load : options.loads) {
    LoadStudy study(load, options, folder);
    study.run();
    if (!options.json) std::printf("%s\n", study.freezes_in_words().c_str());
    for (const Row& row : study.rows()) rows.push_back(row);
    panels.push_back(study.panel());
  }
  print_rows(rows, options.json);
  if (!options.csv.empty()) write_csv(options.csv, rows);
  if (!options.plot.empty()) draw(options.plot, panels);
  std::filesystem::remove_all(folder);
  return 0;
}

}  // namespace

}  // namespace strobe::bench::timing

namespace strobe::bench {

void add_timing_command(CLI::App& app, int& exit_status) {
  using namespace timing;  // NOLINT: this command's own
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("timing",
                         "lateness of the shipped loop's flashes beside cyclictest's: same priority, period, "
                         "CPU and load, in turns.\n"
                         "A witness sees when the machine itself stands still; figures are given with and "
                         "without such freezes.\n"
                         "Example: strobe-bench timing --rounds 3 --seconds 15 --plot timing.png");
  command->add_option("--rounds", options->rounds, "rounds of everything in turn, for each load")
      ->check(CLI::Range(1, 1000));
  command->add_option("--seconds", options->loop.seconds, "length of each part")->check(CLI::Range(1, 3600));
  command->add_option("--priority", options->loop.priority, "real-time priority of both")
      ->check(CLI::Range(11, 98));
  command->add_option("--cpu", options->loop.cpu, "CPU of both; -1: any")->check(CLI::Range(-1, 1023));
  command
      ->add_option("--loads", options->loads,
                   "idle, cpu (both cores busy), memory (and disk); all by default")
      ->delimiter(',')
      ->check(CLI::IsMember(kLoads));
  command->add_flag("--programs", options->programs,
                    "also strobed with strobe fire and strobe-sim, from its journal");
  command->add_flag("--compare", options->compare,
                    "also the loop with shots that start anywhere, and without the simulated rig or chip");
  command->add_flag("--json", options->json, "one JSON object per row");
  command->add_option("--csv", options->csv, "write the rows to this file");
  command->add_option("--plot", options->plot, "draw the distributions into this PNG (gnuplot)");
  command->callback([options, &exit_status] { exit_status = run_timing(*options); });
}

}  // namespace strobe::bench
