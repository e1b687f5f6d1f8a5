// strobe-ends: ends of strobed drawn by the thousand; see tests/ends/run. Prints a row for each kind of fault, and
// what must never be and was.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>
#include <random>
#include <stdexcept>

#include "tests/ends/trial.hpp"
#include "tests/support/private_network.hpp"

using namespace strobe::ends;

namespace {

constexpr int kDone = 0, kFailed = 1;

struct Row {
  int drawn = 0, impossible = 0, ended = 0, late = 0, violated = 0;
  double longest_ms = 0.0;
};

void add(Row& row, const Outcome& outcome) {
  ++row.drawn;
  row.impossible += outcome.done ? 0 : 1;
  row.ended += outcome.ended ? 1 : 0;
  row.late += outcome.late ? 1 : 0;
  row.violated += outcome.violations.empty() ? 0 : 1;
  row.longest_ms = std::max(row.longest_ms, outcome.overrun_ms);
}

void print(const char* title, const std::map<std::string, Row>& rows) {
  fmt::print(
      "\n| {} | drawn | not possible | ended strobed | longest active beyond the plan, ms | violations |\n"
      "|---|---|---|---|---|---|\n",
      title);
  for (const auto& [name, row] : rows)
    fmt::print("| {} | {} | {} | {} | {:.2f} | {} |\n", name, row.drawn, row.impossible, row.ended,
               row.longest_ms, row.violated);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Ends strobed in ways and at moments drawn from a seed, and judges its outputs and its journal.\n"
      "Example: strobe-ends --count 1000 --seed 7; one of them again: strobe-ends --seed 7 --only 12");
  int count = 100, only = 0;
  std::uint64_t seed = std::random_device{}();
  bool verbose = false;
  app.add_option("--count", count, "how many (default 100)")->check(CLI::PositiveNumber);
  app.add_option("--seed", seed, "of all that is drawn (default: a random one, which is printed)");
  app.add_option("--only", only, "the one of this number, with strobed's words")->check(CLI::PositiveNumber);
  app.add_flag("-v,--verbose", verbose, "a line for each");
  CLI11_PARSE(app, argc, argv);
  const strobe::testing::IsolatedEnvironment isolated;
  fmt::print("seed {}\n", seed);
  std::map<std::string, Row> faults, moments;
  int violated = 0;
  for (int number = only > 0 ? only : 1; number <= (only > 0 ? only : count); ++number) {
    const Trial trial = drawn_trial(seed, number);
    Outcome outcome;
    try {
      outcome = run_trial_despite_freezes(trial);
    } catch (const std::runtime_error& error) {
      outcome.violations.emplace_back(error.what());
    }
    add(faults[describe_family(trial)], outcome);
    add(moments[name(trial.moment)], outcome);
    if (verbose || only > 0)
      fmt::print("{}: {}: {}, {:.3f} ms{}\n", number, describe(trial), outcome.ended ? "ended" : "goes on",
                 outcome.overrun_ms, outcome.done ? "" : ", not possible");
    for (const std::string& violation : outcome.violations)
      fmt::print("VIOLATION: {} ({}; --seed {} --only {})\n", violation, describe(trial), seed, number);
    if (only > 0) fmt::print("{}", outcome.log);
    violated += outcome.violations.empty() ? 0 : 1;
    std::fflush(stdout);
    if (isatty(STDERR_FILENO) != 0 || number % 100 == 0)
      fmt::print(stderr, "{} of {}, {} violated\n", number, count, violated);
  }
  if (only == 0) {
    print("fault", faults);
    print("moment", moments);
  }
  return violated == 0 ? kDone : kFailed;
}
