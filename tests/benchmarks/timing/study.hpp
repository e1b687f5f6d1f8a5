// What the studies of the loop's lateness share: options, loads one after the other, and how they end.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/benchmarks/timing/exceedance_plot.hpp"
#include "tests/benchmarks/timing/freeze_detector.hpp"
#include "tests/benchmarks/timing/load.hpp"
#include "tests/benchmarks/timing/loop_run.hpp"
#include "tests/benchmarks/timing/table.hpp"

namespace CLI {
class App;
}

namespace strobe::benchmarks::timing {

struct StudyOptions {
  int rounds = 3;
  LoopSettings loop;
  std::vector<std::string> loads = kLoads;
  bool json = false;
  std::string csv, plot;
};

/// --rounds, --seconds, --priority, --cpu, --loads, --json, --csv and --plot. `options` must outlive the
/// command.
void add_study_options(CLI::App& command, StudyOptions& options);

/// Repeats something under a load while a freeze detector watches.
struct LoadRun {
  std::vector<Freeze> freezes;
  std::string freezes_in_words;
  std::vector<std::vector<CoreInterrupt>> interrupts;  ///< of each core
};
LoadRun under_load(const std::string& load, const StudyOptions& options, const std::filesystem::path& folder,
                   const std::function<void(int round)>& once);

/// What is known of one load.
struct LoadFigures {
  std::vector<Row> rows;
  Panel panel;
  std::string words;  ///< printed above the table
};

/// Studies the loads one after the other, in a scratch folder; prints all rows, writes and draws them where
/// that is asked for, and returns them. std::runtime_error if one cannot be measured, written or drawn.
std::vector<Row> run_study(
    const StudyOptions& options,
    const std::function<LoadFigures(const std::string& load, const std::filesystem::path& folder)>& study);

}  // namespace strobe::benchmarks::timing
