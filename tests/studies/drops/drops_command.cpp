// strobe-bench drops: dropped balls photographed and read, held against the truth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <opencv2/core.hpp>

#include "tests/benchmarks/command.hpp"
#include "tests/studies/digitize/in_order.hpp"
#include "tests/studies/drops/study.hpp"

namespace {

using namespace strobe;
using namespace strobe::studies::drops;

struct Request {
  DropOptions options;
  std::string spacing = "coded";
  int shots = 200, jobs = 1;
  bool each = false;
};

/// More than so many stated sds off, and by what matters: a wrong number.
constexpr double kWrong_sd = 5.0, kWrongE = 0.006, kWrongHeight_m = 0.01;

struct Tally {
  int drops = 0, read = 0, wrong = 0, silent = 0;
  double e_squares = 0.0, e_normalized = 0.0, height_squares = 0.0, height_normalized = 0.0;

  void add(const ReadDrop& d) {
    ++drops;
    if (!d.e_error || !d.height_error_m) return;
    const bool off = is_wrong(d);
    wrong += off;
    silent += off && !d.flagged;
    ++read;
    e_squares += std::pow(*d.e_error, 2);
    e_normalized += std::pow(*d.e_error / d.e_sd, 2);
    height_squares += std::pow(*d.height_error_m, 2);
    height_normalized += std::pow(*d.height_error_m / d.height_sd_m, 2);
  }
  static bool is_wrong(const ReadDrop& d) {
    return (std::abs(*d.e_error) > std::max(kWrongE, kWrong_sd * d.e_sd)) ||
           (std::abs(*d.height_error_m) > std::max(kWrongHeight_m, kWrong_sd * d.height_sd_m));
  }
  void print(const std::string& name) const {
    const auto rms = [this](double squares) { return read > 0 ? std::sqrt(squares / read) : 0.0; };
    fmt::print("{:<20} {:>5} {:>5} {:>5} {:>6} {:>8.5f} {:>6.3f} {:>8.2f} {:>6.3f}\n", name, drops, read, wrong,
               silent, rms(e_squares), rms(e_normalized), 1e3 * rms(height_squares), rms(height_normalized));
  }
};

int run(Request& request) {
  request.options.spacing = request.spacing == "even" ? host::Spacing::even : host::Spacing::coded;
  if (request.jobs > 1) cv::setNumThreads(1);
  std::map<std::string, Tally> of_case;
  std::map<std::string, std::string> refused;
  Tally all;
  const auto done = studies::digitize::try_in_order(
      static_cast<std::size_t>(request.shots), request.jobs,
      [&](std::size_t i) { return read_drop(drop_case(static_cast<int>(i)), request.options); },
      [&](std::size_t i, const ReadDrop& d) {
        const std::string name = name_of(drop_case(static_cast<int>(i)));
        if (!d.refused.empty()) {
          refused[name] = d.refused;
          return;
        }
        of_case[name].add(d);
        all.add(d);
        const bool amiss = !d.e_error || !d.height_error_m || Tally::is_wrong(d);
        if (request.each || amiss)
          fmt::print("  {} {}: {:.1f} ms, {} images, e {:+.5f} ({:.5f}), height {:+.2f} ({:.2f}) mm: {}\n", name,
                     i + 1, d.period_ms, d.images, d.e_error.value_or(std::nan("")), d.e_sd,
                     1e3 * d.height_error_m.value_or(std::nan("")), 1e3 * d.height_sd_m, d.words);
        std::fflush(stdout);
      });
  if (!done) {
    fmt::print(stderr, "strobe-bench: {}\n", done.error().message);
    return 1;
  }
  fmt::print("{:<20} {:>5} {:>5} {:>5} {:>6} {:>8} {:>6} {:>8} {:>6}\n", "drops", "n", "read", "wrong", "silent",
             "e rms", "/ sd", "h rms mm", "/ sd");
  for (const auto& [name, tally] : of_case) tally.print(name);
  all.print("all");
  for (const auto& [name, why] : refused) fmt::print("{:<20} no plan: {}\n", name, why);
  return all.silent == 0 ? 0 : 1;
}

}  // namespace

namespace strobe::studies {

void add_drops_command(CLI::App& app, int& exit_status) {
  const auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand("drops", "Dropped balls photographed and read, held against the truth");
  command->footer(
      "Three balls from five heights in turn, each with the train of a plan for that drop; calibration, surface\n"
      "and drag are off by their sds. By ball and height: drops, those read, wrong ones (5 sd and .006 of e or\n"
      "10 mm off) and those of them without a flag that says so; rms error of e and of the rebound height, and the\n"
      "same over the stated standard uncertainty.\n"
      "Example: strobe-bench drops --shots 200 --jobs 2");
  command->add_option("--shots", request->shots, "Drops in all")->capture_default_str()->check(CLI::Range(1, 100000));
  command->add_option("--seed", request->options.seed, "Of the simulation")->capture_default_str();
  command->add_option("--jobs", request->jobs, "Photographs at a time")->capture_default_str()->check(CLI::Range(1, 256));
  command->add_option("--spacing", request->spacing, "coded or even trains")
      ->check(CLI::IsMember({"coded", "even"}))
      ->capture_default_str();
  command->add_option("--period-ms", request->options.period_ms, "Instead of the plan's own")
      ->check(CLI::Range(0.1, 1000.0));
  command->add_flag("--each", request->each, "A line for each drop, not only for those amiss");
  command->callback([request, &exit_status] { exit_status = run(*request); });
}

}  // namespace strobe::studies
