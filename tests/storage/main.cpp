// Draws faults of the disk and judges what a host stores; the table at the end counts fault by file by what was told.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstring>
#include <map>
#include <random>

#include "tests/storage/trial.hpp"

namespace {

/// Memory that is refused and files that are taken away have no errno.
bool is_error(const std::string& call) { return call != "memory" && call.find(' ') == call.npos; }

}  // namespace

int main(int argc, char** argv) {
  using namespace strobe::storage;
  CLI::App app("Faults of the disk while a host stores, drawn from a seed.");
  int trials = 1;
  std::uint64_t seed = std::random_device{}();
  bool verbose = false;
  app.add_option("--trials", trials, "how many")->capture_default_str();
  app.add_option("--seed", seed, "of the first; the others follow (default: a fresh one, printed)");
  app.add_flag("--verbose", verbose, "each trial");
  CLI11_PARSE(app, argc, argv);
  fmt::print("{} trials from seed {}\n", trials, seed);
  std::map<std::string, std::map<Ending, int>> table;
  int violations = 0;
  for (int i = 0; i < trials; ++i) {
    const Trial trial = draw(seed + static_cast<std::uint64_t>(i));
    const Verdict verdict = run_trial(trial);
    const std::string file = trial.target == "session"
                                 ? trial.fault.file.empty() ? "any of a session" : trial.fault.file
                                 : trial.target;
    ++table[fmt::format("{:<18} {:<7} {:<6}", file, trial.fault.call,
                        is_error(trial.fault.call) ? strerrorname_np(trial.fault.error) : "")]
           [verdict.ending];
    if (verbose)
      fmt::print("{} {}: {}; told: {}\n", trial.seed, to_text(trial.fault), name(verdict.ending),
                 verdict.told);
    if (verdict.violation.empty()) continue;
    ++violations;
    fmt::print("VIOLATION {}: {}; told: \"{}\"; repeat with: strobe-storage --seed {} --verbose\n",
               to_text(trial.fault), verdict.violation, verdict.told, trial.seed);
  }
  fmt::print("{:<34}", "file, call, error");
  for (int e = 0; e < 5; ++e) fmt::print(" | {}", name(static_cast<Ending>(e)));
  fmt::print("\n");
  for (auto& [row, endings] : table) {
    fmt::print("{:<34}", row);
    for (int e = 0; e < 5; ++e)
      fmt::print(" | {:>{}}", endings[static_cast<Ending>(e)], std::strlen(name(static_cast<Ending>(e))));
    fmt::print("\n");
  }
  fmt::print("{} violations\n", violations);
  return violations == 0 ? 0 : 1;
}
