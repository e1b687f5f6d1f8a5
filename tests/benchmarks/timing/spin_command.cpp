// strobe-bench spin: how long the loop should be awake and spin before an instant: lateness against processor
// time.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include "tests/benchmarks/command.hpp"
#include "tests/benchmarks/timing/study.hpp"

namespace strobe::benchmarks::timing {

namespace {

struct Options : StudyOptions {
  std::vector<int> spins_us{0, 50, 100, 150, 200, 300, 400};
  std::vector<int> wake_aheads_us{0, 400, 800, 1500};
};

struct Cell {
  int wake_ahead_us = 0, spin_us = 0;
  std::vector<Sample> samples;
  double cpu_percent_sum = 0.0;

  std::string name() const {
    return "awake " + std::to_string(wake_ahead_us) + " us, spin " + std::to_string(spin_us) + " us";
  }
};

constexpr double kEnoughP99Us = 1.0;

/// Every pair of the two, but for those that are the same to the loop: awake no longer than it spins.
std::vector<Cell> cells_of(const Options& options) {
  std::vector<Cell> cells;
  for (const int wake_ahead_us : options.wake_aheads_us) {
    for (const int spin_us : options.spins_us)
      if (wake_ahead_us == 0 || wake_ahead_us > spin_us) cells.push_back({wake_ahead_us, spin_us, {}, 0.0});
  }
  return cells;
}

void add_run(const Options& options, LoopFixture& bench, Cell& cell) {
  LoopSettings settings = options.loop;
  settings.spin = microseconds(cell.spin_us);
  settings.wake_ahead = microseconds(cell.wake_ahead_us);
  const LoopRun run = bench.run(settings);
  append(cell.samples, run.issue);
  cell.cpu_percent_sum += run.cpu_percent;
}

/// p99 over the spin, a curve for each wake-ahead, and the share of a core of each.
Panel panel_of(const std::string& load, const std::vector<Cell>& cells, const std::vector<Row>& rows) {
  Panel panel{load + ", freezes left out", "spin [us]", "lateness p99 [us]; share of a core [%]", false, true,
              std::vector<Curve>()};
  std::vector<Curve> shares;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].wake_ahead_us != cells[i - 1].wake_ahead_us) {
      const std::string awake = "awake " + std::to_string(cells[i].wake_ahead_us) + " us";
      panel.curves.push_back({awake + ": p99", {}, {}});
      shares.push_back({awake + ": core %", {}, {}});
    }
    const auto add = [&](Curve& curve, double y) {
      curve.x.push_back(cells[i].spin_us);
      curve.y.push_back(std::max(y, 1e-3));
    };
    add(panel.curves.back(), rows[i].lateness.p99_us);
    add(shares.back(), rows[i].cpu_percent);
  }
  panel.curves.insert(panel.curves.end(), shares.begin(), shares.end());
  return panel;
}

LoadFigures study(const std::string& load, const Options& options, const std::filesystem::path& folder) {
  std::vector<Cell> cells = cells_of(options);
  LoopFixture bench;
  const LoadRun watched = under_load(load, options, folder, [&](int) {
    for (Cell& cell : cells) add_run(options, bench, cell);
  });
  std::vector<Row> rows;
  for (const Cell& cell : cells) {
    rows.push_back({load, cell.name(), "left out", percentiles(outside(cell.samples, watched.freezes)),
                    cell.cpu_percent_sum / options.rounds, ""});
  }
  Panel panel = panel_of(load, cells, rows);
  return {std::move(rows), std::move(panel), load + ": " + watched.freezes_in_words};
}

/// Of those with a p99 as wished under every load, the one that takes the least of a core at its dearest.
void print_cheapest(const std::vector<Row>& rows, std::size_t cells) {
  const Row* best = nullptr;
  double best_percent = 0.0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    double p99_us = 0.0, percent = 0.0;
    for (std::size_t i = cell; i < rows.size(); i += cells) {
      p99_us = std::max(p99_us, rows[i].lateness.p99_us);
      percent = std::max(percent, rows[i].cpu_percent);
    }
    if (p99_us > kEnoughP99Us || (best != nullptr && percent >= best_percent)) continue;
    best = &rows[cell];
    best_percent = percent;
  }
  if (best == nullptr)
    std::printf("none has p99 <= %.0f us under every load\n", kEnoughP99Us);
  else
    std::printf("cheapest with p99 <= %.0f us under every load: %s (%.1f %% of a core)\n", kEnoughP99Us,
                best->what.c_str(), best_percent);
}

int run_spin(const Options& options) {
  const std::vector<Row> rows =
      run_study(options, [&](const std::string& load, const std::filesystem::path& folder) {
        return study(load, options, folder);
      });
  if (!options.json) print_cheapest(rows, cells_of(options).size());
  return 0;
}

}  // namespace

}  // namespace strobe::benchmarks::timing

namespace strobe::benchmarks {

void add_spin_command(CLI::App& app, int& exit_status) {
  using namespace timing;  // NOLINT: this command's own
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "spin",
      "how long the loop should be awake, and how long of that spin, before an instant: lateness of its "
      "flashes against the share of a core in a train.\n"
      "A second of a cell has some 300 flashes.\n"
      "Example: strobe-bench spin --wake-ahead 0,1500 --spin 200 --rounds 4 --seconds 10 --plot spin.svg");
  add_study_options(*command, *options);
  command->add_option("--spin,--spin-us", options->spins_us, "lengths to try, in us")
      ->delimiter(',')
      ->check(CLI::Range(0, 1000));
  command
      ->add_option("--wake-ahead,--wake-ahead-us", options->wake_aheads_us,
                   "how long before an instant it wakes, in us; 0: when it begins to spin")
      ->delimiter(',')
      ->check(CLI::Range(0, 20'000));
  command->callback([options, &exit_status] { exit_status = run_spin(*options); });
}

}  // namespace strobe::benchmarks
