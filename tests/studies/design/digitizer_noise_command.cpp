// strobe-bench digitizer-noise: the digitizer's errors on rendered photographs under drawn conditions.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "tests/benchmarks/command.hpp"
#include "tests/studies/design/noise_photographs.hpp"
#include "tests/studies/digitize/in_order.hpp"

namespace {

using namespace strobe;
using namespace strobe::studies::design;

struct Options {
  int photographs = 100, each = 1, jobs = 1, first = 1;
  std::uint64_t seed = 1;
  std::string csv;
};

std::string optional_field(const std::optional<double>& value) {
  return value ? fmt::format("{:.6g}", *value) : std::string();
}

std::string csv_lines(const NoisePhotograph& p) {
  const NoiseCondition& c = p.condition;
  const std::string photograph = fmt::format(
      "{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:."
      "6g},{:.6g}",
      p.number, c.diameter_px, c.blur_px, c.motion_px, c.exposure, c.full_well_e, c.read_noise_e, c.bits,
      c.line_contrast, c.step, c.period_s, p.line_width_px, p.wall, p.plate, p.grain, p.hair_px, p.fuzz_px);
  std::string lines;
  for (const NoiseSample& s : p.images) {
    lines += fmt::format("image,{},{:.5g},{:.5g}", photograph, s.motion_px, s.heading_rad);
    for (const double share : s.overlap.shares) lines += fmt::format(",{:.5g}", share);
    lines += fmt::format(",{},{},", int{s.rebound}, int{s.found});
    if (s.found)
      lines += fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},", s.along_px, s.across_px, s.centre_sd_px,
                           s.diameter_px, s.diameter_sd_px);
    else
      lines += ",,,,,";
    lines += optional_field(s.equator_rad) + "," + optional_field(s.equator_sd_rad) + "\n";
  }
  lines += fmt::format("photograph,{},{},{}", photograph, p.invented, p.surface_sd_px);
  for (const double error : p.surface_px) lines += fmt::format(",{:.6g}", error);
  return lines + "\n";
}

Result<void> study(const Options& options) {
  std::ofstream file(options.csv, std::ios::binary);
  std::size_t skipped = 0;
  const auto done = studies::digitize::try_in_order(
      static_cast<std::size_t>(options.photographs), options.jobs,
      [&](std::size_t i) -> Result<std::string> {
        const auto p = noise_photograph(options.seed, options.first + static_cast<int>(i), options.each);
        return p ? csv_lines(*p) : std::string("skipped," + p.error().message + "\n");
      },
      [&](std::size_t, const std::string& lines) {
        if (lines.starts_with("skipped")) ++skipped;
        file << lines << std::flush;
      });
  fmt::print("{} skipped\n", skipped);
  return done;
}

int run(const Options& options) {
  cv::setNumThreads(1);
  const auto done = study(options);
  if (done) return 0;
  fmt::print(stderr, "strobe-bench: {}\n", done.error().message);
  return 1;
}

}  // namespace

namespace strobe::studies {

void add_digitizer_noise_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "digitizer-noise", "Errors of the digitizer on rendered photographs under drawn conditions");
  command->add_option("--photographs", options->photographs)->capture_default_str();
  command->add_option("--each", options->each)->capture_default_str();
  command->add_option("--first", options->first)->capture_default_str();
  command->add_option("--seed", options->seed)->capture_default_str();
  command->add_option("--jobs", options->jobs)->capture_default_str();
  command->add_option("--csv", options->csv);
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::studies
