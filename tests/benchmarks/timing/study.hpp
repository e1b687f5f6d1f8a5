// What the studies of the loop's lateness share: options, loads one after the other, and how they end.
#pragma once

#include <sys/types.h>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/benchmarks/timing/figures.hpp"
#include "tests/benchmarks/timing/freeze_detector.hpp"
#include "tests/benchmarks/timing/runs.hpp"

namespace CLI {
class App;
}

namespace strobe::benchmarks::timing {

inline const std::vector<std::string> kLoads{"idle", "cpu", "memory"};

/// What else the machine does while the loop is measured: processes of ordinary priority that end with this
/// object.
class Load {
 public:
  /// "idle": nothing; "cpu": one busy process a core; "memory": one process a core that copies 64 MiB to and
  /// fro, and one that writes 64 MiB to a file in the folder and syncs it, repeatedly.
  Load(const std::string& kind, const std::filesystem::path& folder);
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;
  ~Load();

 private:
  template <typename Work>
  void start(Work work);
  std::vector<pid_t> processes_;
  std::filesystem::path file_;
};

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
