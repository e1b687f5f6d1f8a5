// strobe-campaign: trials of one kind by the thousand; see tests/campaigns/run. Exit status 0: nothing was violated.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "tests/campaigns/campaign.hpp"
#include "tests/campaigns/ends.hpp"
#include "tests/campaigns/loss.hpp"
#include "tests/campaigns/resume.hpp"
#include "tests/campaigns/storage.hpp"
#include "tests/support/private_network.hpp"

using namespace strobe;
using namespace strobe::campaigns;

namespace {

constexpr int kDone = 0, kFailed = 1;

struct Options {
  int trials = 0, only = 0;
  std::uint64_t seed = std::random_device{}();
  bool verbose = false;
  loss::Choice loss;
  resume::Trial resume;
};

struct Kind {
  const char* name;
  const char* about;
  int trials;  ///< unless told otherwise
  Judge judge;
};

std::vector<Kind> kinds(const Options& options) {
  return {
      {"ends", "strobed ended by signals, held threads, failing calls: no output stays active", 1000,
       [](Draws& draws) { return ends::run_trial_despite_freezes(ends::drawn(draws)); }},
      {"loss", "links that lose; host and strobed killed in their shots: nothing journalled is missing", 11,
       [&options](Draws& draws) { return loss::run_trial(loss::drawn(options.loss, draws), draws); }},
      {"resume", "sessions interrupted and gone on with: nothing is missing, nothing counts twice", 20,
       [&options](Draws& draws) { return resume::run_trial(resume::drawn(options.resume, draws), draws); }},
      {"storage", "the disk fails while a host stores: every loss is told", 1000,
       [](Draws& draws) { return storage::run_trial(storage::drawn(draws)); }},
  };
}

void add_common(CLI::App& command, const Kind& kind, Options& options) {
  command.add_option("--trials", options.trials, fmt::format("how many (default {})", kind.trials))
      ->check(CLI::PositiveNumber);
  command.add_option("--seed", options.seed,
                     "of all that is drawn (default: a random one, which is printed)");
  command.add_option("--only", options.only, "the one of this number, with the programs' words")
      ->check(CLI::PositiveNumber);
  command.add_flag("-v,--verbose", options.verbose,
                   "a line for each, and the programs' words where something was violated");
}

void add_own(CLI::App& command, loss::Choice& loss, resume::Trial& resume) {
  if (command.get_name() == "loss") {
    command.add_flag("--links", loss.links, "links only, unless there are kills");
    command.add_option("--shots", loss.shots, "shots that must count, per link")->capture_default_str();
    command.add_option("--kills", loss.kills, "of the host, and as many of strobed (default 100)");
    command.add_option("--kill-loss", loss.kill_loss, "loss of the link meanwhile, 0 to 0.5");
    command.add_flag("--full-exposure", loss.full_exposure, "as shipped, instead of a third of it");
  } else if (command.get_name() == "resume") {
    command.add_option("--interruptions", resume.interruptions, "of each session")->capture_default_str();
    command.add_option("--shots", resume.shots, "that each session is to hold")->capture_default_str();
    command.add_flag("--photographs", resume.photographs, "in each session; else in every fourth");
  }
}

/// What was asked for of a kind's own options.
std::string own_options(const CLI::App& command) {
  std::string words;
  for (const CLI::Option* option : command.get_options([](const CLI::Option* one) { return !one->empty(); }))
    if (const std::string name = option->get_name();
        name != "--trials" && name != "--seed" && name != "--only" && name != "--verbose")
      words += fmt::format(" {}={}", name, option->results().back());
  return words;
}

int run(const Kind& kind, const Options& options, const std::string& own) {
  const testing::IsolatedEnvironment isolated;
  const int first = std::max(1, options.only);
  const int last = options.only > 0 ? options.only : options.trials > 0 ? options.trials : kind.trials;
  fmt::print("{}{}, {} trials, seed {}\n", kind.name, own, last - first + 1, options.seed);
  Tables tables;
  for (int number = first; number <= last; ++number) {
    const Verdict verdict = judged(kind.judge, options.seed, number);
    tables.add(verdict);
    if (options.verbose || options.only > 0) fmt::print("{}: {}\n", number, summary(verdict));
    fmt::print("{}", complaint(verdict, repetition(kind.name, options.seed, number, own)));
    const bool looked_at = options.only > 0 || (options.verbose && !verdict.violations.empty());
    if (looked_at) fmt::print("{}", verdict.words);
    std::fflush(stdout);
    if (isatty(STDERR_FILENO) != 0 || number % std::max(1, last / 10) == 0)
      fmt::print(stderr, "{} of {}, {} violated\n", number, last, tables.violated());
  }
  fmt::print("{}\n{} of {} trials violated\n", options.only > 0 ? "" : tables.text(), tables.violated(),
             last - first + 1);
  return tables.violated() == 0 ? kDone : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Runs the shipped programs through trials drawn from a seed, and judges what they leave.\n"
      "Example: strobe-campaign ends --trials 1000 --seed 7\n"
      "One of them again: strobe-campaign ends --seed 7 --only 12");
  app.require_subcommand(1);
  Options options;
  const std::vector<Kind> all = kinds(options);
  for (const Kind& kind : all) {
    CLI::App& command = *app.add_subcommand(kind.name, kind.about);
    add_common(command, kind, options);
    add_own(command, options.loss, options.resume);
  }
  CLI11_PARSE(app, argc, argv);
  const CLI::App& asked = *app.get_subcommands().front();
  for (const Kind& kind : all)
    if (asked.get_name() == kind.name) return run(kind, options, own_options(asked));
  return kFailed;
}
