// strobe-bench efficiency: how near the estimators come to the Cramer-Rao bound.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "tests/benchmarks/command.hpp"
#include "tests/studies/efficiency/report.hpp"

namespace {

using namespace strobe::studies;

struct Options {
  int shots = 20000;
  std::uint64_t seed = 1;
  int threads = 2;
  std::vector<std::string> conditions;
  std::vector<std::string> scenarios;
  bool rows = false, json = false;
};

/// Those of `all` that are asked for by name, or all. A name that is none stops the program.
template <typename Item, typename NameOf>
std::vector<Item> chosen(std::vector<Item> all, const std::vector<std::string>& names, const char* option,
                         NameOf name_of) {
  for (const std::string& name : names) {
    if (std::ranges::find(all, name, name_of) != all.end()) continue;
    std::string known;
    for (const Item& item : all) known.append(1, ' ').append(name_of(item));
    throw CLI::ValidationError(option, fmt::format("no \"{}\" among{}", name, known));
  }
  if (!names.empty()) {
    std::erase_if(all,
                  [&](const Item& item) { return std::ranges::find(names, name_of(item)) == names.end(); });
  }
  return all;
}

/// Shows how far the study is until it goes out of scope.
class Progress {
 public:
  Progress(std::size_t scenarios, std::size_t conditions)
      : total_(static_cast<int>(scenarios * conditions)), thread_([this](const std::stop_token& stop) {
          for (int tick = 0; !stop.stop_requested(); ++tick) {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            if (tick % 20 == 19) fmt::print(stderr, "\r{} of {} conditions ", done.load(), total_);
          }
          fmt::print(stderr, "\r{:40}\r", "");
        }) {}

  std::atomic<int> done = 0;

 private:
  int total_;
  std::jthread thread_;
};

int efficiency(const Options& options) {
  Plan plan{.shots = options.shots,
            .seed = options.seed,
            .threads = options.threads,
            .bounces = chosen(strobe::test::thesis_bounces(), options.conditions, "--conditions",
                              [](const strobe::test::Bounce& b) { return b.label; }),
            .methods = all_methods()};
  const auto scenarios =
      chosen(all_scenarios(), options.scenarios, "--scenarios", [](const Scenario& s) { return s.name; });
  std::vector<Result> results;
  {
    Progress progress(scenarios.size(), plan.bounces.size());
    for (const Scenario& scenario : scenarios)
      results.push_back({scenario, plan.methods, run(plan, scenario, progress.done)});
  }
  if (!options.json)
    fmt::print(
        "{} shots of each of {} conditions over 50 phases of the flash train, seed {}\n"
        "centre, diameter, surface 0.5 mm, equator 1 degree; flight with gravity, drag and Magnus lift\n",
        options.shots, plan.bounces.size(), options.seed);
  for (const Result& result : results)
    if (options.json)
      fmt::print("{}", json_lines(result));
    else
      fmt::print("{}{}{}", summary(result), times_worse(result), options.rows ? long_table(result) : "");
  return 0;
}

}  // namespace

namespace strobe::studies {

void add_efficiency_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "efficiency",
      "errors of the estimators on simulated shots, against the Cramer-Rao bound and the stated sd.\n"
      "Example: strobe-bench efficiency --shots 20000 --scenarios stated-5,estimated-5 --rows");
  command->add_option("--shots", options->shots, "of each condition")
      ->check(CLI::Range(50, 10000000))
      ->capture_default_str();
  command->add_option("--conditions", options->conditions, "of the thesis, as zero_23,top_18; default all 21")
      ->delimiter(',');
  command
      ->add_option(
          "--scenarios", options->scenarios,
          "stated-N, estimated-N (noise), level-N (camera), late-N (a flash), N = 3 or 5 images a leg; "
          "default all 8")
      ->delimiter(',');
  command->add_option("--seed", options->seed, "repeats a run, with any number of threads")
      ->capture_default_str();
  command->add_option("--threads", options->threads, "run in parallel")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--rows", options->rows, "print each condition's row as well");
  command->add_flag("--json", options->json, "one object per condition, method and quantity");
  command->callback([options, &exit_status] { exit_status = efficiency(*options); });
}

}  // namespace strobe::studies
