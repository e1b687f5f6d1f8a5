#include "tests/benchmarks/timing/study.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/support/temporary_folder.hpp"

namespace strobe::benchmarks::timing {

void add_study_options(CLI::App& command, StudyOptions& options) {
  command.add_option("--rounds", options.rounds, "rounds of everything in turn, for each load")
      ->check(CLI::Range(1, 1000));
  command.add_option("--seconds", options.loop.seconds, "length of each part")->check(CLI::Range(1, 3600));
  command.add_option("--priority", options.loop.priority, "real-time priority of what is measured")
      ->check(CLI::Range(11, 98));
  command.add_option("--cpu", options.loop.cpu, "CPU of what is measured; -1: any")
      ->check(CLI::Range(-1, 1023));
  command
      .add_option("--loads", options.loads, "idle, cpu (both cores busy), memory (and disk); all by default")
      ->delimiter(',')
      ->check(CLI::IsMember(kLoads));
  command.add_flag("--json", options.json, "one JSON object per row");
  command.add_option("--csv", options.csv, "write the rows to this file");
  command.add_option("--plot", options.plot, "draw into this SVG, with its numbers beside it (.csv)");
}

LoadRun under_load(const std::string& load, const StudyOptions& options, const std::filesystem::path& folder,
                   const std::function<void(int round)>& once) {
  FreezeDetector detector(options.loop.priority - 10, FreezeDetector::Method::interrupts);
  const Load running(load, folder);
  for (int round = 1; round <= options.rounds; ++round) {
    std::fprintf(stderr, "%s, round %d of %d\n", load.c_str(), round, options.rounds);
    once(round);
  }
  std::vector<Freeze> freezes = detector.stop();
  std::string words = freezes_in_words(freezes, detector.by());
  return {std::move(freezes), std::move(words), detector.interrupts()};
}

std::vector<Row> run_study(
    const StudyOptions& options,
    const std::function<LoadFigures(const std::string& load, const std::filesystem::path& folder)>& study) {
  const testing::TemporaryFolder folder;
  std::vector<Row> rows;
  std::vector<Panel> panels;
  for (const std::string& load : options.loads) {
    LoadFigures figures = study(load, folder.path());
    if (!options.json && !figures.words.empty()) std::printf("%s\n", figures.words.c_str());
    rows.insert(rows.end(), figures.rows.begin(), figures.rows.end());
    panels.push_back(std::move(figures.panel));
  }
  print_rows(rows, options.json);
  if (!options.csv.empty()) write_csv(options.csv, rows);
  if (!options.plot.empty()) draw(options.plot, panels);
  return rows;
}

}  // namespace strobe::benchmarks::timing
