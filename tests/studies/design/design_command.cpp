// strobe-bench design: foretold uncertainties against the errors of simulated shots.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "sim/loading/load_scene.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/studies/design/design_study.hpp"
#include "tests/studies/in_parallel.hpp"

namespace {

using namespace strobe::studies;
using strobe::reduction::kQuantityCount;
using strobe::reduction::kQuantityNames;

struct Options {
  int designs = 100, shots = 400, threads = 2;
  std::uint64_t seed = 1;
  bool json = false, all = false;
};

// Of fewer shots the rms itself is not known to a few percent.
constexpr double kEnoughShots = 0.25;

struct Ratios {
  std::vector<double> ratios;
  int shots = 0, gross = 0;
  void add(const Foretold& f) {
    ratios.push_back(f.ratio());
    shots += f.shots;
    gross += f.gross;
  }
  double gross_percent() const { return 100.0 * gross / std::max(1, shots + gross); }
  double within(double share) const {
    const auto close = std::ranges::count_if(ratios, [&](double r) { return std::abs(std::log(r)) <= std::log1p(share); });
    return ratios.empty() ? 0.0 : static_cast<double>(close) / static_cast<double>(ratios.size());
  }
  double quantile(double p) {
    if (ratios.empty()) return 0.0;
    std::ranges::sort(ratios);
    return ratios[static_cast<std::size_t>(p * static_cast<double>(ratios.size() - 1))];
  }
};

void print_row(std::string_view name, Ratios& r, bool json) {
  if (json) {
    const nlohmann::ordered_json line{{"quantity", name}, {"designs", r.ratios.size()}, {"within_10_percent", r.within(0.1)},
                                      {"within_20_percent", r.within(0.2)}, {"median", r.quantile(0.5)}, {"gross_percent", r.gross_percent()}};
    fmt::print("{}\n", line.dump());
    return;
  }
  fmt::print("{:<18}{:>9}{:>10.2f}{:>10.2f}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.2f}\n", name, r.ratios.size(), r.within(0.1),
             r.within(0.2), r.quantile(0.0), r.quantile(0.5), r.quantile(1.0), r.gross_percent());
}

int run(const Options& options) {
  const auto base = strobe::sim::load_scene("zero_23");
  if (!base) {
    fmt::print(stderr, "strobe-bench: {}\n", base.error().message);
    return 2;
  }
  std::vector<DesignOutcome> outcomes(static_cast<std::size_t>(options.designs));
  in_parallel(outcomes.size(), static_cast<unsigned>(options.threads), [&](std::size_t i) {
    const DrawnDesign drawn = drawn_design(*base, options.seed, static_cast<int>(i));
    outcomes[i] = foretold_and_found(drawn, options.shots, options.seed + i);
  });
  std::array<Ratios, kQuantityCount> by_quantity;
  Ratios all;
  int readable_right = 0;
  for (const DesignOutcome& o : outcomes) {
    readable_right += std::abs(o.predicted_readable - o.readable) <= 0.1 ? 1 : 0;
    if (options.all) fmt::print("# {}: readable {:.2f}, foretold {:.2f}\n", o.name, o.readable, o.predicted_readable);
    for (std::size_t q = 0; q < kQuantityCount; ++q) {
      const Foretold& f = o.quantities[q];
      if (f.shots < kEnoughShots * options.shots || !(f.error > 0.0) || !(f.predicted > 0.0)) continue;
      by_quantity[q].add(f);
      all.add(f);
      if (options.all && std::abs(std::log(f.ratio())) > std::log(1.1))
        fmt::print("    {:<18}{:>10.4g} foretold, {:>10.4g} stated, {:>10.4g} found: {:.3f}\n", kQuantityNames[q], f.predicted, f.stated, f.error, f.ratio());
    }
  }
  if (!options.json)
    fmt::print("{} designs of {} shots, seed {}; share of readable shots foretold to 0.1 in {} designs\n{:<18}{:>9}{:>10}{:>10}"
               "{:>10}{:>10}{:>10}{:>10}\n",
               options.designs, options.shots, options.seed, readable_right, "foretold over rms", "designs", "to 10 %",
               "to 20 %", "least", "median", "largest", "gross, %");
  for (std::size_t q = 0; q < kQuantityCount; ++q)
    if (!by_quantity[q].ratios.empty()) print_row(kQuantityNames[q], by_quantity[q], options.json);
  print_row("all", all, options.json);
  return 0;
}

}  // namespace

namespace strobe::studies {

void add_design_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "design", "what strobe design foretells of drawn designs against the rms error of their simulated shots.\n"
                "Scale, ball, drag and spin decay are wrong by draws of their sds, anew in each shot.\n"
                "Example: strobe-bench design --designs 100 --shots 400");
  command->add_option("--designs", options->designs, "drawn")->check(CLI::Range(1, 100000))->capture_default_str();
  command->add_option("--shots", options->shots, "of each")->check(CLI::Range(2, 1000000))->capture_default_str();
  command->add_option("--seed", options->seed, "repeats a run, with any number of threads")->capture_default_str();
  command->add_option("--threads", options->threads, "run in parallel")->check(CLI::Range(1, 256))->capture_default_str();
  command->add_flag("--all", options->all, "each design, and each number that is more than 10 % off");
  command->add_flag("--json", options->json, "one object per quantity, and one of all");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::studies
