// strobe-bench fit-coverage: how often the intervals of `strobe fit` hold the truth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/benchmarks/command.hpp"
#include "tests/common/impact_fit/sessions.hpp"
#include "tests/common/impact_fit/shot_sessions.hpp"
#include "tests/studies/in_parallel.hpp"

namespace {

using namespace strobe;
using namespace strobe::testing;

/// After kSessionKinds: shots by the simulator, fitted by the contact mechanics.
constexpr std::size_t kOde = kSessionKinds.size();
constexpr std::size_t kRows = kSessionKinds.size() + 2;

std::string_view row_name(std::size_t row) {
  if (row == kOde) return "ode";
  return row < kSessionKinds.size() ? kSessionKinds[row] : "all";
}

struct Options {
  int sessions = 500;
  int shots_of_each = 3;
  std::uint64_t seed = 1;
  unsigned threads = 2;
  std::vector<std::string> kinds;
  bool json = false;
};

struct Outcome {
  std::size_t kind = 0;
  std::optional<impact::ModelFit> fit;
  impact::ParameterValues truth{};
};

/// Without a fit where there is none.
Outcome fitted_shots(const std::vector<sim::Scene>& scenes, int shots_of_each, std::uint64_t seed) {
  Outcome out{.kind = kOde, .fit = {}, .truth = {}};
  const auto session = shoot_session(scenes, shots_of_each, seed);
  if (!session) return out;
  out.truth = session->truth;
  if (auto fit = impact::fit(session->shots, session->options)) out.fit = *std::move(fit);
  return out;
}

/// The session of that number, the same whatever the number of threads.
Outcome fitted(std::size_t kind, std::uint64_t seed) {
  std::mt19937_64 source(seed);
  const Session session = draw_session(static_cast<SessionKind>(kind), source);
  Outcome out{.kind = kind, .fit = {}, .truth = session.truth};
  if (auto fit = impact::fit(session.shots, session.options)) out.fit = *std::move(fit);
  return out;
}

std::vector<std::size_t> kinds_of(const Options& options) {
  std::vector<std::size_t> out;
  for (std::size_t kind = 0; kind < kSessionKinds.size(); ++kind)
    if (options.kinds.empty() || std::ranges::find(options.kinds, kSessionKinds[kind]) != options.kinds.end())
      out.push_back(kind);
  if (std::ranges::find(options.kinds, row_name(kOde)) != options.kinds.end()) out.push_back(kOde);
  return out;
}

void print(const Options& options, std::string_view kind, impact::Parameter parameter, const Coverage& c) {
  const auto share = [](int part, int whole) { return whole > 0 ? static_cast<double>(part) / whole : 0.0; };
  if (options.json) {
    const nlohmann::ordered_json line{{"kind", kind},
                                      {"parameter", impact::name(parameter)},
                                      {"intervals", c.intervals},
                                      {"hold", share(c.held, c.intervals)},
                                      {"truth_below", share(c.below, c.intervals)},
                                      {"truth_above", share(c.above, c.intervals)},
                                      {"rms_z", c.rms_z()},
                                      {"limits", c.limits},
                                      {"limits_hold", share(c.limits_held, c.limits)}};
    fmt::print("{}\n", line.dump());
    return;
  }
  fmt::print("{:<10} {:<15} {:>9} {:>7.3f} {:>12.3f} {:>12.3f} {:>6.2f} {:>7} {:>6.3f}\n", kind,
             impact::name(parameter), c.intervals, share(c.held, c.intervals), share(c.below, c.intervals),
             share(c.above, c.intervals), c.rms_z(), c.limits, share(c.limits_held, c.limits));
}

/// One row for each kind and parameter, then the rows of all kinds together.
void report(const Options& options, const std::vector<Outcome>& outcomes) {
  std::vector<CoverageByParameter> table(kRows);
  int refused = 0;
  for (const Outcome& o : outcomes) {
    refused += o.fit ? 0 : 1;
    for (std::size_t p = 0; o.fit && p < impact::kParameterCount; ++p)
      for (const std::size_t row : {o.kind, kRows - 1}) table[row][p].add(o.fit->parameters[p], o.truth[p]);
  }
  if (!options.json)
    fmt::print(
        "{} sessions, seed {}; {} without a fit\n{:<10} {:<15} {:>9} {:>7} {:>12} {:>12} {:>6} {:>7} {:>6}\n",
        outcomes.size(), options.seed, refused, "kind", "", "intervals", "hold", "truth below", "truth above",
        "rms z", "limits", "hold");
  for (std::size_t row = 0; row < table.size(); ++row)
    for (std::size_t p = 0; p < impact::kParameterCount; ++p)
      if (const Coverage& c = table[row][p]; c.intervals + c.limits > 0)
        print(options, row_name(row), static_cast<impact::Parameter>(p), c);
}

int coverage(const Options& options) {
  const std::vector<std::size_t> kinds = kinds_of(options);
  std::vector<sim::Scene> scenes;
  if (std::ranges::find(kinds, kOde) != kinds.end()) {
    auto loaded = scenes_of_conditions();
    if (!loaded) {
      fmt::print(stderr, "strobe-bench: {}\n", loaded.error().message);
      return 1;
    }
    scenes = *std::move(loaded);
  }
  std::vector<Outcome> outcomes(static_cast<std::size_t>(options.sessions));
  studies::in_parallel(outcomes.size(), options.threads, [&](std::size_t i) {
    const std::size_t kind = kinds[i % kinds.size()];
    const std::uint64_t seed = options.seed * 1'000'003 + i;
    outcomes[i] = kind == kOde ? fitted_shots(scenes, options.shots_of_each, seed) : fitted(kind, seed);
  });
  report(options, outcomes);
  return 0;
}

}  // namespace

namespace strobe::studies {

void add_fit_coverage_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  std::vector<std::string> kinds(kSessionKinds.begin(), kSessionKinds.end());
  kinds.emplace_back(row_name(kOde));
  CLI::App* command =
      app.add_subcommand("fit-coverage",
                         "how often the 95 % intervals of `strobe fit` hold the truth of simulated sessions, "
                         "and mu's lower limits where all "
                         "shots grip.\nExample: strobe-bench fit-coverage --sessions 500 --seed 1");
  command->add_option("--sessions", options->sessions, "of 12 to 60 shots, the kinds in turn")
      ->check(CLI::Range(1, 10000000))
      ->capture_default_str();
  command
      ->add_option("--kinds", options->kinds,
                   "of sessions; default all but ode: the simulator's shots, fitted by the contact mechanics")
      ->delimiter(',')
      ->check(CLI::IsMember(kinds));
  command->add_option("--shots", options->shots_of_each, "ode: of each of the 21 conditions")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "repeats a run, with any number of threads")
      ->capture_default_str();
  command->add_option("--threads", options->threads, "run in parallel")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one object per kind and parameter");
  command->callback([options, &exit_status] { exit_status = coverage(*options); });
}

}  // namespace strobe::studies
