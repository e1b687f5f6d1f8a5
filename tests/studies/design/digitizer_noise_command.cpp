// strobe-bench digitizer-noise: the digitizer's errors on rendered photographs of drawn conditions, against
// what host/design predicts.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "tests/benchmarks/command.hpp"
#include "tests/studies/design/noise_photographs.hpp"
#include "tests/studies/design/noise_ratios.hpp"
#include "tests/studies/digitize/in_order.hpp"

namespace {

using namespace strobe;
using namespace strobe::studies::design;

struct Options {
  int photographs = 100, each = 1, jobs = 1;
  std::uint64_t seed = 1;
  std::string csv;
};

constexpr std::string_view kCsvHead =
    "photograph,rebound,diameter_px,blur_px,motion_px,exposure,full_well_e,read_noise_e,bits,line_contrast,"
    "line_width,"
    "readable,found,along_px,across_px,centre_sd_px,diameter_error_px,diameter_sd_px,equator_rad,equator_sd_"
    "rad\n";

std::string csv_lines(const NoisePhotograph& p) {
  std::string lines;
  for (const NoiseSample& s : p.images) {
    const host::PictureConditions& c = s.picture;
    lines += fmt::format("{},{:d},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{:.6g},{:.6g},{:.6g},{:d}",
                         p.number, s.rebound, c.ball_diameter_px, c.blur_px, c.motion_px, c.exposure,
                         c.full_well_e, c.read_noise_e, p.condition.bits, c.line_contrast, c.line_width,
                         host::readable_share(c.overlap, c.exposure), s.found);
    lines += s.found ? fmt::format(",{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}", s.along_px, s.across_px,
                                   s.centre_sd_px, s.diameter_px, s.diameter_sd_px)
                     : ",,,,,";
    lines += s.equator_rad ? fmt::format(",{:.6g},{:.6g}\n", *s.equator_rad, s.equator_sd_rad) : ",,\n";
  }
  return lines;
}

void print_head() {
  fmt::print("{:<42}", "");
  for (const std::string_view name : kNoiseKindNames) fmt::print(" {:>9}", name);
  fmt::print(" {:>22} {:>22}\n", "found/predicted", "equators/predicted");
}

std::string count(const NoiseCount& c) {
  return c.of > 0 ? fmt::format("{:.2f}/{:.2f} of {:>5}", static_cast<double>(c.found) / c.of,
                                c.predicted / c.of, c.of)
                  : std::string("-");
}

void print_row(const std::string& name, const NoiseScore& score, double (NoiseRatio::*value)() const) {
  fmt::print("{:<42}", name);
  for (const NoiseRatio& ratio : score.ratios)
    fmt::print(" {:>9}", ratio.groups() > 0 ? fmt::format("{:.2f}", (ratio.*value)()) : "-");
  fmt::print(" {:>22} {:>22}\n", count(score.images), count(score.equators));
  std::fflush(stdout);
}

std::string words(const NoiseCondition& c) {
  return fmt::format("{:.0f} px blur {:.1f} light {:.2f} step {:.2f}", c.diameter_px, c.blur_px, c.exposure,
                     c.step);
}

/// How far conditions' ratios are from 1, each of as many groups as it has.
class Scatter {
 public:
  void add(const NoiseScore& condition) {
    for (std::size_t kind = 0; kind < kNoiseKindNames.size(); ++kind) {
      const NoiseRatio& ratio = condition.ratios[kind];
      if (ratio.groups() == 0) continue;
      const double off = std::log(std::max(ratio.measured(), 0.01));
      squares_[kind] += ratio.groups() * off * off;
      groups_[kind] += ratio.groups();
    }
  }
  void print() const {
    fmt::print("{:<42}", "conditions' rms of log(measured/predicted)");
    for (std::size_t kind = 0; kind < kNoiseKindNames.size(); ++kind)
      fmt::print(" {:>9.2f}", std::sqrt(squares_[kind] / groups_[kind]));
    fmt::print("\n");
  }

 private:
  std::array<double, kNoiseKindNames.size()> squares_{}, groups_{};
};

class Study {
 public:
  explicit Study(const Options& options) : options_(options) {}

  Result<void> run() {
    if (!options_.csv.empty()) {
      csv_.open(options_.csv, std::ios::binary);
      csv_ << kCsvHead;
      if (!csv_) return fail(options_.csv + ": cannot be written");
    }
    print_head();
    const auto done = studies::digitize::try_in_order(
        static_cast<std::size_t>(options_.photographs), options_.jobs,
        [&](std::size_t i) {
          return noise_photograph(options_.seed, static_cast<int>(i) + 1, options_.each);
        },
        [&](std::size_t, const NoisePhotograph& photograph) { take(photograph); });
    if (done) print_sums();
    return done;
  }

 private:
  void take(const NoisePhotograph& photograph) {
    csv_ << csv_lines(photograph);
    all_.add(photograph);
    of_condition_.add(photograph);
    if (photograph.number % options_.each != 0) return;
    if (options_.each > 1) print_row(words(photograph.condition), of_condition_, &NoiseRatio::measured);
    scatter_.add(of_condition_);
    of_condition_ = {};
  }

  void print_sums() const {
    print_row("all: measured over predicted sd", all_, &NoiseRatio::measured);
    print_row("all: stated over predicted sd", all_, &NoiseRatio::stated);
    print_row("all: common over predicted sd", all_, &NoiseRatio::common);
    if (options_.each > 1) scatter_.print();
    fmt::print(
        "{} photographs; {} images invented; {} beyond what is predicted; legs or photographs whose variance "
        "is more than {:.0f} times as predicted:",
        all_.photographs, all_.invented, all_.unknown, NoiseRatio::kMaxExcess);
    for (std::size_t kind = 0; kind < kNoiseKindNames.size(); ++kind)
      fmt::print(" {} {} of {}{}", kNoiseKindNames[kind], all_.ratios[kind].excessive(),
                 all_.ratios[kind].groups(), kind + 1 < kNoiseKindNames.size() ? "," : "\n");
  }

  const Options& options_;
  std::ofstream csv_;
  NoiseScore all_, of_condition_;
  Scatter scatter_;
};

int run(const Options& options) {
  if (options.jobs > 1) cv::setNumThreads(1);
  const auto done = Study(options).run();
  if (done) return 0;
  fmt::print(stderr, "strobe-bench: {}\n", done.error().message);
  return 1;
}

}  // namespace

namespace strobe::studies {

void add_digitizer_noise_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "digitizer-noise",
      "Errors of the digitizer on rendered photographs of drawn conditions, over what host/design predicts.\n"
      "Example: strobe-bench digitizer-noise --photographs 200 --each 8 --seed 2");
  command->add_option("--photographs", options->photographs, "Rendered and digitized")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  command->add_option("--each", options->each, "Of so many the same condition; a line for each condition")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command->add_option("--seed", options->seed, "Of conditions and simulation")->capture_default_str();
  command->add_option("--jobs", options->jobs, "Photographs at a time")
      ->capture_default_str()
      ->check(CLI::Range(1, 256));
  command->add_option("--csv", options->csv, "One line an image");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::studies
