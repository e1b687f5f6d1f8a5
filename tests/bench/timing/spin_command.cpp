// strobe-bench spin: how long the loop should spin before an instant: lateness against processor time.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "tests/bench/command.hpp"
#include "tests/bench/timing/exceedance_plot.hpp"
#include "tests/bench/timing/load.hpp"
#include "tests/bench/timing/loop_run.hpp"
#include "tests/bench/timing/table.hpp"

namespace strobe::bench::timing {

namespace {

struct Options {
  int rounds = 3;
  LoopSettings loop;
  std::vector<std::string> loads = kLoads;
  std::vector<int> spins_us{0, 25, 50, 75, 100, 150, 200, 300, 400};
  bool json = false;
  std::string csv;
  std::string plot;
};

struct Point {
  int spin_us = 0;
  std::vector<Sample> samples;
  double cpu_percent_sum = 0.0;
};

constexpr double kEnoughP99Us = 1.0;

std::vector<Point> measure(const std::string& load_name, const Options& options,
                           const std::filesystem::path& folder, std::vector<Freeze>& freezes) {
  std::vector<Point> points;
  for (const int spin_us : options.spins_us) points.push_back({spin_us, {}, 0.0});
  Witness witness(options.loop.priority - 10);
  const Load load(load_name, folder);
  LoopBench bench(true);
  for (int round = 1; round <= options.rounds; ++round) {
    std::fprintf(stderr, "%s, round %d of %d\n", load_name.c_str(), round, options.rounds);
    for (Point& point : points) {
      LoopSettings settings = options.loop;
      settings.spin = microseconds(point.spin_us);
      const LoopRun run = bench.run(settings);
      append(point.samples, run.issue);
      point.cpu_percent_sum += run.cpu_percent;
    }
  }
  freezes = witness.stop();
  return points;
}

Panel panel_of(const std::string& load, const std::vector<Row>& rows, const std::vector<int>& spins_us) {
  Panel panel{
      load + ", freezes left out", "spin [us]", "lateness [us]; share of a core [%]", false, true, {}};
  panel.curves = {{"p50", {}, {}}, {"p99", {}, {}}, {"p99.9", {}, {}}, {"core %", {}, {}}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Percentiles& p = rows[i].lateness;
    const double values[] = {p.p50_us, p.p99_us, p.p999_us, rows[i].cpu_percent};
    for (std::size_t k = 0; k < panel.curves.size(); ++k) {
      panel.curves[k].x.push_back(spins_us[i]);
      panel.curves[k].y.push_back(std::max(values[k], 1e-3));
    }
  }
  return panel;
}

int run_spin(const Options& options) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("strobe-bench-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::vector<Row> all;
  std::vector<Panel> panels;
  std::vector<bool> enough(options.spins_us.size(), true);
  for (const std::string& load : options.loads) {
    std::vector<Freeze> freezes;
    const std::vector<Point> points = measure(load, options, folder, freezes);
    std::vector<Row> rows;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Percentiles p = percentiles(outside(points[i].samples, freezes));
      if (p.p99_us > kEnoughP99Us) enough[i] = false;
      rows.push_back({load, "spin " + std::to_string(points[i].spin_us) + " us", "left out", p,
                      points[i].cpu_percent_sum / options.rounds, ""});
    }
    panels.push_back(panel_of(load, rows, options.spins_us));
    all.insert(all.end(), rows.begin(), rows.end());
  }
  print_rows(all, options.json);
  const auto least = std::find(enough.begin(), enough.end(), true);
  if (!options.json && least != enough.end()) {
    std::printf("shortest spin with p99 <= %.0f us under every load: %d us\n", kEnoughP99Us,
                options.spins_us[static_cast<std::size_t>(least - enough.begin())]);
  }
  if (!options.csv.empty()) write_csv(options.csv, all);
  if (!options.plot.empty()) draw(options.plot, panels);
  std::filesystem::remove_all(folder);
  return 0;
}

}  // namespace

}  // namespace strobe::bench::timing

namespace strobe::bench {

void add_spin_command(CLI::App& app, int& exit_status) {
  using namespace timing;  // NOLINT: this command's own
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("spin",
                                         "how long the loop should spin before an instant: lateness of its "
                                         "flashes against the share of a core.\n"
                                         "Example: strobe-bench spin --rounds 3 --seconds 5 --plot spin.png");
  command->add_option("--rounds", options->rounds, "rounds of all lengths in turn, for each load")
      ->check(CLI::Range(1, 1000));
  command->add_option("--seconds", options->loop.seconds, "length of each part")->check(CLI::Range(1, 3600));
  command->add_option("--priority", options->loop.priority, "real-time priority")->check(CLI::Range(11, 98));
  command->add_option("--cpu", options->loop.cpu, "CPU of the loop; -1: any")->check(CLI::Range(-1, 1023));
  command
      ->add_option("--loads", options->loads,
                   "idle, cpu (both cores busy), memory (and disk); all by default")
      ->delimiter(',')
      ->check(CLI::IsMember(kLoads));
  command->add_option("--spin-us", options->spins_us, "lengths to try")
      ->delimiter(',')
      ->check(CLI::Range(0, 1000));
  command->add_flag("--json", options->json, "one JSON object per row");
  command->add_option("--csv", options->csv, "write the rows to this file");
  command->add_option("--plot", options->plot, "draw lateness and processor time into this PNG (gnuplot)");
  command->callback([options, &exit_status] { exit_status = run_spin(*options); });
}

}  // namespace strobe::bench
