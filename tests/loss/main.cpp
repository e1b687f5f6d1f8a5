// strobe-loss: the shipped programs across links that lose, and killed at random instants of a shot. Prints
// a table row for each, and what must hold and does not.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <random>

#include "tests/loss/trials.hpp"
#include "tests/support/private_network.hpp"

using namespace strobe::loss;

namespace {

constexpr int kDone = 0, kFailed = 1;

struct Row {
  std::string name;
  LinkFaults faults;
  double cut_s = 0.0;
};

const std::vector<Row>& link_rows() {
  static const std::vector<Row> rows{
      {"no loss", {}, 0},
      {"5 % loss", {0.05, 0, 0, 60}, 0},
      {"20 % loss", {0.2, 0, 0, 60}, 0},
      {"50 % loss", {0.5, 0, 0, 60}, 0},
      {"20 % doubled", {0, 0.2, 0, 60}, 0},
      {"20 % late by up to 60 ms", {0, 0, 0.2, 60}, 0},
      {"20 % lost, 10 % doubled, 20 % late", {0.2, 0.1, 0.2, 60}, 0},
      {"cut for 10 s in a shot", {}, 10},
      {"20 % loss, cut for 10 s", {0.2, 0, 0, 60}, 10},
  };
  return rows;
}

int say(const std::string& name, const TrialResult& result) {
  const Audit& a = result.audit;
  fmt::print("| {} | {} | {} | {} | {} | {} | {}/{} | {} | {} | {} | {} | {:.0f} |\n", name, result.kills,
             a.boots, result.link.came, result.link.lost + result.link.cut, a.journalled, a.missing,
             a.shots_missing, fmt::format("{}/{}", a.cut_off_reported, a.cut_off),
             fmt::format("{} ({} flagged)", a.readouts, a.flagged), a.twice, a.incomplete_unflagged,
             result.duration_s);
  std::fflush(stdout);
  for (const std::string& violation : a.violations) fmt::print(stderr, "VIOLATION: {}\n", violation);
  if (!result.fired) fmt::print(stderr, "the series did not end as ordered:\n{}\n", result.words);
  return a.violations.empty() && result.fired ? kDone : kFailed;
}

void head() {
  fmt::print(
      "| what | kills | boots | packets | lost | events journalled | missing events/summaries | shots cut "
      "off, "
      "reported/all | readouts | twice | incomplete unflagged | s "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Fires across links that lose and kills host and firmware in their shots; see tests/loss/run.");
  int shots = 3, kills = 0;
  double kill_loss = 0.0;
  std::uint64_t seed = std::random_device{}();
  bool links = false, full = false;
  app.add_flag("--links", links, "the table of links");
  app.add_option("--shots", shots, "shots that must count, per link (default 3)");
  app.add_option("--kills", kills, "kills of the host, and as many of the firmware");
  app.add_option("--kill-loss", kill_loss, "loss of the link meanwhile, 0 to 0.5");
  app.add_option("--seed", seed, "of everything that is drawn (default: a random one, which is printed)");
  app.add_flag("--full-exposure", full, "the shipped plan's exposure instead of a third of it");
  CLI11_PARSE(app, argc, argv);
  const strobe::testing::IsolatedEnvironment isolated;
  fmt::print("seed {}\n", seed);
  head();
  int status = kDone;
  if (links)
    for (const Row& row : link_rows())
      status |= say(row.name, run_trial(LinkTrial{row.faults, row.cut_s, shots, seed++, !full}));
  if (kills > 0) {
    for (const Victim victim : {Victim::host, Victim::firmware}) {
      const char* name = victim == Victim::host ? "the host killed" : "strobed killed";
      KillTrial trial{victim, kills, kill_loss, seed++, !full};
      trial.progress = [&](int done) {
        if (isatty(STDERR_FILENO) != 0 || done % 10 == 0)
          fmt::print(stderr, "{}: {} of {}\n", name, done, kills);
      };
      status |= say(kill_loss > 0 ? fmt::format("{}, {:.0f} % loss", name, kill_loss * 100) : name,
                    run_trial(trial));
    }
  }
  return status;
}
