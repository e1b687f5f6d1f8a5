// strobe-bench trade: speed against accuracy of every method, in one table.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>

#include "host/figures/svg.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/studies/trade/report.hpp"
#include "tests/studies/trade/studies.hpp"

namespace strobe::studies {

namespace {

using namespace trade;

struct Options {
  Effort effort;
  std::string csv, plot;
  std::vector<std::string> only;
  bool json = false;
};

/// On a terminal: which study is under way.
void tell(const char* what) {
  if (isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\r{:60}\r{}", "", what);
}

bool wanted(const Options& options, const std::string& name) {
  return options.only.empty() || std::ranges::find(options.only, name) != options.only.end();
}

std::vector<Study> measure(const Options& options, std::vector<std::string>& missing) {
  std::vector<Study> all;
  const auto begins = [&](const char* name) {
    if (!wanted(options, name)) return false;
    tell(name);
    return true;
  };
  if (begins("impact"))
    for (Study& s : lift_off_studies(options.effort)) all.push_back(std::move(s));
  if (begins("course")) all.push_back(course_study(options.effort));
  if (begins("flight")) all.push_back(flight_study(options.effort));
  if (begins("estimators"))
    for (Study& s : estimator_studies(options.effort)) all.push_back(std::move(s));
  if (begins("shots"))
    if (auto study = shot_study(options.effort)) all.push_back(std::move(*study));
  if (begins("engines")) all.push_back(engine_study(options.effort, missing));
  return all;
}

bool write(const std::string& path, const std::string& text) {
  if (path.empty()) return true;
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) fmt::print(stderr, "strobe-bench trade: {}: cannot be written\n", path);
  return !file.fail();
}

int run(Options options) {
  if (options.effort.quick) {
    options.effort.scenes = std::min(options.effort.scenes, 6);
    options.effort.shots = std::min(options.effort.shots, 20);
    options.effort.repetitions = std::min(options.effort.repetitions, 3);
  }
  std::vector<std::string> missing;
  const std::vector<Study> studies = measure(options, missing);
  tell("");
  if (options.json) {
    fmt::print("{}", json_lines(studies));
  } else {
    for (const Study& study : studies) fmt::print("{}{}\n", table_text(study), engines_text(study));
    for (const std::string& engine : missing) fmt::print("{}: not installed\n", engine);
  }
  if (!write(options.csv, csv_text(studies))) return 2;
  if (!options.plot.empty()) {
    const std::filesystem::path file(options.plot);
    const auto drawn = figures::write_figure(figure_of(studies),
                                             file.has_parent_path() ? file.parent_path() : ".", file.stem());
    if (!drawn) {
      fmt::print(stderr, "strobe-bench trade: {}\n", drawn.error().message);
      return 1;
    }
  }
  const auto broken = broken_invariants(studies);
  for (const std::string& line : broken) fmt::print(stderr, "strobe-bench trade: {}\n", line);
  return broken.empty() ? 0 : 1;
}

}  // namespace

void add_trade_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("trade",
                                         "speed against accuracy: cost and error of every impact model, "
                                         "flight model and estimator, and of general "
                                         "engines where they are installed.\n"
                                         "Example: strobe-bench trade --csv trade.csv --plot trade.svg");
  command
      ->add_option("--studies", options->only,
                   "of impact,course,flight,estimators,shots,engines; default all")
      ->delimiter(',')
      ->check(CLI::IsMember({"impact", "course", "flight", "estimators", "shots", "engines"}));
  command->add_option("--scenes", options->effort.scenes, "of the practical range")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  command->add_option("--shots", options->effort.shots, "of each condition, for estimators")
      ->check(CLI::Range(20, 10000000))
      ->capture_default_str();
  command->add_option("--repetitions", options->effort.repetitions, "of each timing; the least counts")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_option("--seed", options->effort.seed, "of the scenes and the noise")->capture_default_str();
  command->add_option("--csv", options->csv, "write all figures to this file");
  command->add_option("--plot", options->plot, "draw this .svg, and write its numbers beside it (.csv)");
  command->add_flag("--json", options->json, "one object per method, nothing else on stdout");
  command->add_flag("--quick", options->effort.quick, "few scenes and steps, to see that all works");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::studies
