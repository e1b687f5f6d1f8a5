// strobe-bench timing: lateness of the shipped loop's flashes beside cyclictest's, interleaved in one run,
// under loads.
#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "tests/benchmarks/command.hpp"
#include "tests/benchmarks/timing/figures.hpp"
#include "tests/benchmarks/timing/runs.hpp"
#include "tests/benchmarks/timing/study.hpp"

namespace strobe::benchmarks::timing {

namespace {

struct Options : StudyOptions {
  bool programs = false;
  std::filesystem::path other_strobed;
};

/// What is measured in turns; the first is what the ratios are of, the second what they are to.
struct Part {
  std::string name;
  std::vector<Sample> samples;
  double cpu_percent = -1.0;
};

constexpr const char* kLoop = "loop";
constexpr Duration kLate = microseconds(100);  ///< as the rig file's
constexpr const char* kCyclictest = "cyclictest";

class LoadStudy {
 public:
  LoadStudy(std::string load, const Options& options, std::filesystem::path folder)
      : load_(std::move(load)), options_(options), folder_(std::move(folder)) {}

  void run() {
    watched_ = under_load(load_, options_, folder_, [this](int) { measure(); });
  }

  LoadFigures figures() const {
    return {rows(), panel(),
            load_ + ": " + watched_.freezes_in_words + "; " + std::to_string(shots_) + " shots, " +
                std::to_string(aborted_) + " aborted by a late flash; left out of cyclictest's wake-ups " +
                share_left_out(parts_[1]) + ", of the loop's flashes " + share_left_out(parts_[0]) +
                why_late()};
  }

 private:
  void measure() {
    take(kLoop, LoopFixture().run(options_.loop));
    append(part(kCyclictest).samples, run_cyclictest(options_.loop));
    if (options_.programs) {
      take("all programs", run_programs(options_.loop, folder_));
      take("all programs, rig time", run_programs(options_.loop, folder_, {}, "wall"));
    }
    if (!options_.other_strobed.empty())
      take("with the other strobed", run_programs(options_.loop, folder_, options_.other_strobed));
  }

  std::vector<Row> rows() const {
    std::vector<Row> rows;
    for (const bool left_out : {true, false}) {
      const Percentiles reference = percentiles(values(parts_[1], left_out));
      for (const Part& each : parts_) {
        Row row{load_,
                each.name,
                left_out ? "left out" : "included",
                percentiles(values(each, left_out)),
                each.cpu_percent,
                ""};
        if (each.name != kCyclictest) row.ratio = ratios(row.lateness, reference);
        rows.push_back(row);
      }
    }
    return rows;
  }

  Panel panel() const {
    Panel panel{
        load_ + ", freezes left out", "lateness [us]", "share of wake-ups that are later", true, true, {}};
    for (const Part& each : parts_) panel.curves.push_back(exceedance(each.name, values(each, true)));
    return panel;
  }

  /// Only where the core of each is known.
  std::string why_late() const {
    if (options_.loop.cpu < 0) return "";
    std::string words;
    for (const Part& each : parts_) {
      const KernelActivity held = kernel_activity(each.samples, watched_.freezes, watched_.interrupts, kLate);
      words += "\n  " + each.name + ": " + in_words(held, kLate);
    }
    return words;
  }
  std::string share_left_out(const Part& each) const {
    const auto all = static_cast<double>(each.samples.size());
    const auto kept = static_cast<double>(values(each, true).size());
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "%.1f %%", 100.0 * (1.0 - kept / all));
    return text.data();
  }

  Part& part(const std::string& name) {
    for (Part& each : parts_)
      if (each.name == name) return each;
    return parts_.emplace_back(Part{name, {}, -1.0});
  }
  void take(const std::string& name, const LoopRun& run) {
    Part& taken = part(name);
    append(taken.samples, run.issue);
    if (run.cpu_percent > 0.0) taken.cpu_percent = run.cpu_percent;
    shots_ += run.shots;
    aborted_ += run.aborted;
  }
  std::vector<double> values(const Part& each, bool left_out) const {
    return left_out ? outside(each.samples, watched_.freezes) : latenesses(each.samples);
  }

  std::string load_;
  const Options& options_;
  std::filesystem::path folder_;
  std::vector<Part> parts_;
  LoadRun watched_;
  int shots_ = 0, aborted_ = 0;
};

int run_timing(const Options& options) {
  run_study(options, [&](const std::string& load, const std::filesystem::path& folder) {
    LoadStudy study(load, options, folder);
    study.run();
    return study.figures();
  });
  return 0;
}

}  // namespace

}  // namespace strobe::benchmarks::timing

namespace strobe::benchmarks {

void add_timing_command(CLI::App& app, int& exit_status) {
  using namespace timing;  // NOLINT: this command's own
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("timing",
                         "lateness of the shipped loop's flashes beside cyclictest's: same priority, period, "
                         "CPU and load, in turns.\n"
                         "A detector sees when a core itself stands still; figures are given with and "
                         "without such freezes.\n"
                         "Example: strobe-bench timing --rounds 3 --seconds 15 --plot timing.svg");
  add_study_options(*command, *options);
  command->add_flag(
      "--programs", options->programs,
      "also strobed with strobe fire and strobe-sim, from its journal: in the machine's time and in the "
      "rig's, which is to be like that of an idle machine");
  command
      ->add_option("--other-strobed", options->other_strobed,
                   "also with this strobed, such as one made with another libgpiod, in turns with --programs")
      ->check(CLI::ExistingFile);
  command->callback([options, &exit_status] { exit_status = run_timing(*options); });
}

}  // namespace strobe::benchmarks
