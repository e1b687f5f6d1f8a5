// strobe-bench thesis: simulated conditions against the thesis's Tables 5 to 10.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include "tests/benchmarks/command.hpp"
#include "tests/studies/thesis/report.hpp"

namespace {

using namespace strobe::studies;

struct Options {
  std::string dashpot = "tied", vertical = "by-speed-and-slip";
  int shots = 50;
  std::uint64_t seed = 1;
  bool json = false;
  std::string folder = STROBE_THESIS_FOLDER;
};

template <std::size_t n>
std::size_t place_of(const std::array<std::string_view, n>& names, const std::string& name) {
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

std::string title_of(Dashpot dashpot, Vertical vertical) {
  return fmt::format("contact, {} constants, e and dwell {}", dashpot == Dashpot::tied ? "4" : "5",
                     kVerticalNames[static_cast<std::size_t>(vertical)]);
}

int fail_with(const strobe::Error& error) {
  fmt::print(stderr, "strobe-bench: {}\n", error.message);
  return 1;
}

/// What is under way, on stderr.
void show(const std::string& what) {
  fmt::print(stderr, "\r{:60}\r", what);
  std::fflush(stderr);
}

/// All that is printed, by name.
struct Way {
  std::string name;
  std::vector<Cell> cells;
};

void print_report(const Options& options, const Predictions& chosen, const std::vector<Way>& ways) {
  fmt::print(
      "Simulated lift-offs of the thesis's 21 conditions against its Tables 5 to 10. The mechanics' "
      "constants\n"
      "are fitted to two spins and predict the third, all three ways. z = (predicted - mean)/published sd.\n"
      "Inputs of every prediction: vx, vy and spin at touchdown. {}\n\n",
      options.vertical == "measured"
          ? "Besides: the condition's own e (hence vy at lift-off) and\ndwell time, marked so; of the "
            "figures only the "
            "middle ones have that vy in them."
          : "Nothing else: e and the dwell time follow from\nthe other spins too. (Chosen with all sets in "
            "view: "
            "that e goes with |vy| and s/|vy|, that the dashpot is tied.)");
  fmt::print("{}: {}\n\n{}\n", ways.front().name, "as predicted, with z", constants_table(chosen));
  fmt::print("{}\n", condition_table(ways.front().cells));
  fmt::print("{}", summary_header());
  for (const Way& way : ways) fmt::print("{}", summary_line(way.name, way.cells));
  fmt::print("\nBeyond 3, {}:\n{}", ways.front().name, beyond_3(chosen));
}

strobe::Result<std::vector<Way>> run(const Options& options, const strobe::thesis::Data& data,
                                     Predictions& chosen) {
  std::vector<Way> ways(1);
  for (const Dashpot dashpot : {Dashpot::tied, Dashpot::fitted}) {
    for (const Vertical vertical : {Vertical::measured, Vertical::by_speed, Vertical::by_speed_and_slip}) {
      const std::string title = title_of(dashpot, vertical);
      show(title);
      auto predictions = predict_all(data, dashpot, vertical);
      if (!predictions) return tl::unexpected(predictions.error());
      if (kDashpotNames[static_cast<std::size_t>(dashpot)] == options.dashpot &&
          kVerticalNames[static_cast<std::size_t>(vertical)] == options.vertical) {
        ways.front() = {title, predictions->cells};
        chosen = *std::move(predictions);
      } else {
        ways.push_back({title, std::move(predictions->cells)});
      }
    }
  }
  auto algebraic = algebraic_models(data);
  if (!algebraic) return tl::unexpected(algebraic.error());
  for (Algebraic& model : *algebraic) ways.push_back({"algebraic " + model.model, std::move(model.cells)});
  for (const bool exact : {true, false}) {
    if (options.shots == 0) break;
    show("shots");
    auto shots = shoot_all(chosen, options.shots, options.seed, exact);
    if (!shots) return tl::unexpected(shots.error());
    if (shots->without_readout > 0)
      fmt::print(stderr, "strobe-bench: {}: {} of {} shots without a readout\n", shots->name,
                 shots->without_readout, shots->shots);
    ways.push_back(
        {exact ? shots->name : fmt::format("means of {} shots", options.shots), std::move(shots->cells)});
  }
  return ways;
}

int against_thesis(const Options& options) {
  const auto data = strobe::thesis::load(options.folder, strobe::thesis::Version::corrected);
  if (!data) return fail_with(data.error());
  Predictions chosen;
  const auto ways = run(options, *data, chosen);
  if (!ways) return fail_with(ways.error());
  for (const Way& way : *ways)
    if (options.json) fmt::print("{}", json_lines(way.name, way.cells));
  if (!options.json) print_report(options, chosen, *ways);
  return 0;
}

}  // namespace

namespace strobe::studies {

void add_thesis_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "thesis",
      "the thesis's 21 conditions, each spin predicted from the other two, against its tables.\n"
      "Example: strobe-bench thesis --e-and-dwell measured");
  command
      ->add_option("--dashpot", options->dashpot,
                   "of the tangential spring: fitted, or tied (a constant less)")
      ->check(CLI::IsMember({"tied", "fitted"}))
      ->capture_default_str();
  command
      ->add_option("--e-and-dwell", options->vertical,
                   "measured: each condition's own; else from the other two spins as well")
      ->check(CLI::IsMember({"measured", "by-speed", "by-speed-and-slip"}))
      ->capture_default_str();
  command->add_option("--shots", options->shots, "whole simulated shots of each condition; 0: none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "repeats the shots")->capture_default_str();
  command->add_flag("--json", options->json, "one object per cell");
  command->add_option("--data", options->folder, "folder of the tables")->check(CLI::ExistingDirectory);
  command->callback([options, &exit_status] { exit_status = against_thesis(*options); });
}

}  // namespace strobe::studies
