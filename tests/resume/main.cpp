// Sessions interrupted at drawn instants, by the dozen; see tests/resume/run.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <random>

#include "tests/resume/trial.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/temporary_folder.hpp"

int main(int argc, char** argv) {
  using namespace strobe::resume;
  CLI::App app(
      "Interrupts sessions at instants drawn from a seed and goes on with them; see tests/resume/run.");
  int rounds = 1, interruptions = 6, shots = 4;
  std::uint64_t seed = std::random_device{}();
  bool photographs = false, verbose = false;
  app.add_option("--rounds", rounds, "sessions")->capture_default_str();
  app.add_option("--seed", seed, "of the first; the others follow (default: a fresh one, printed)");
  app.add_option("--interruptions", interruptions, "of each session")->capture_default_str();
  app.add_option("--shots", shots, "that each session is to hold")->capture_default_str();
  app.add_flag("--photographs", photographs, "rendered and digitized; else points of the simulated tablet");
  app.add_flag("--verbose", verbose, "what the programs said, where something was violated");
  CLI11_PARSE(app, argc, argv);
  if (const std::string problem = strobe::testing::enter_private_network(); !problem.empty())
    fmt::print(stderr, "no private network ({}), going on in this one\n", problem);
  const strobe::testing::TemporaryFolder home;  // for the key that the programs make
  setenv("XDG_CONFIG_HOME", home.path().c_str(), 1);
  fmt::print("{} sessions from seed {}\n", rounds, seed);
  int fired = 0, cut_off = 0, rows = 0, counted = 0;
  std::size_t violations = 0;
  for (int round = 0; round < rounds; ++round) {
    const Trial trial{seed + static_cast<std::uint64_t>(round), shots, interruptions, photographs};
    const Verdict verdict = run_trial(trial);
    fired += verdict.fired, cut_off += verdict.cut_off, rows += verdict.rows, counted += verdict.counted;
    violations += verdict.violations.size();
    fmt::print("seed {}: {} fired, {} without an end, {} rows, {} count; {}\n", trial.seed, verdict.fired,
               verdict.cut_off, verdict.rows, verdict.counted, verdict.happened);
    for (const std::string& violation : verdict.violations) fmt::print("VIOLATION: {}\n", violation);
    if (verbose && !verdict.violations.empty()) fmt::print("{}\n", verdict.words);
    std::fflush(stdout);
  }
  fmt::print("{} fired, {} without an end, {} rows, {} count, {} violations\n", fired, cut_off, rows, counted,
             violations);
  return violations == 0 ? 0 : 1;
}
