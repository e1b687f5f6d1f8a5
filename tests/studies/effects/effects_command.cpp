// strobe-bench effects: models that leave effects out against full ones over random scenes.
#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/units/tolerance.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/sim/effects/trial.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;

struct Options {
  int scenes = 2000, shots = 4;
  std::uint64_t first = 0;
  int threads = 2;
  std::vector<std::string> tolerances{"0.01%", "0.1%", "1%", "5%"};
  std::string scenes_folder;  ///< empty: not written
};

/// As a file that strobe-sim reads; its first line says the flashes' period. Returns false if it cannot be written.
bool write_scenes(const Options& options) {
  std::filesystem::create_directories(options.scenes_folder);
  for (int i = 0; i < options.scenes; ++i) {
    const auto random = test::random_scene(options.first + static_cast<std::uint64_t>(i));
    const auto path = std::filesystem::path(options.scenes_folder) / (random.scene.name + ".toml");
    std::ofstream file(path);
    file << test::as_toml(random);
    if (!file.flush()) {
      fmt::print(stderr, "strobe-bench: {}: cannot be written\n", path.string());
      return false;
    }
  }
  return true;
}

/// Of the thread itself, so that a busy machine does not count.
double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double shots_s(const test::RandomScene& random, const Model& model, int shots) {
  auto shooter = Shooter::make(random.scene, 7, model, random.settings);
  double least = 1e9;
  for (int round = 0; shooter && round < 3; ++round) {
    const double start = processor_s();
    for (int shot = 1; shot <= shots; ++shot) shooter->shoot(shot);
    least = std::min(least, processor_s() - start);
  }
  return least;
}

double middle(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// All that was found, gathered from the threads.
class Findings {
 public:
  explicit Findings(const std::vector<double>& tolerances)
      : tolerances_(tolerances), largest_share_(tolerances.size()), speed_ups_(tolerances.size()) {}

  void add(const test::RandomScene& random, const test::Trial& trial, const std::vector<double>& speed_ups) {
    const std::lock_guard lock(mutex_);
    ++scenes_;
    for (std::size_t i = 0; i < tolerances_.size(); ++i) {
      largest_share_[i] = std::max(largest_share_[i], trial.tolerances[i].largest_share);
      speed_ups_[i].push_back(speed_ups[i]);
    }
    for (const test::Violation& v : trial.violations) {
      ++violations_;
      fmt::print("{}, shot {}, {}: {} changes by {:.4g}, allowed {:.4g}\n{}\n", random.scene.name, v.shot,
                 tolerance_text(v.tolerance), reduction::name(v.quantity), v.difference, v.allowed,
                 test::as_toml(random));
    }
    if (scenes_ % 50 == 0) fmt::print(stderr, "\r{} scenes ", scenes_);
  }

  int report() {
    fmt::print(stderr, "\r{:20}\r", "");
    fmt::print("{} random scenes; {} violations\n\n", scenes_, violations_);
    fmt::print("{:<10} {:>28} {:>16}\n", "tolerance", "largest change/tolerance", "median speed-up");
    for (std::size_t i = 0; i < tolerances_.size(); ++i)
      fmt::print("{:<10} {:>28.3f} {:>16.2f}\n", tolerance_text(tolerances_[i]), largest_share_[i],
                 middle(speed_ups_[i]));
    return violations_ > 0 ? 1 : 0;
  }

 private:
  const std::vector<double>& tolerances_;
  std::mutex mutex_;
  int scenes_ = 0, violations_ = 0;
  std::vector<double> largest_share_;
  std::vector<std::vector<double>> speed_ups_;
};

int study(const Options& options) {
  std::vector<double> tolerances;
  for (const std::string& text : options.tolerances) {
    const auto tolerance = parse_tolerance(text);
    if (!tolerance) {
      fmt::print(stderr, "strobe-bench: --tolerances: {}\n", tolerance.error().message);
      return 2;
    }
    tolerances.push_back(*tolerance);
  }
  if (!options.scenes_folder.empty()) return write_scenes(options) ? 0 : 2;
  Findings findings(tolerances);
  std::atomic<int> next = 0;
  const auto work = [&] {
    for (int i = next++; i < options.scenes; i = next++) {
      const auto random = test::random_scene(options.first + static_cast<std::uint64_t>(i));
      const test::Trial trial = test::check_choices(random, tolerances, options.shots);
      const double full_s = shots_s(random, Model::full(), options.shots);
      std::vector<double> speed_ups;
      for (const test::ToleranceOutcome& outcome : trial.tolerances)
        speed_ups.push_back(full_s / shots_s(random, outcome.model, options.shots));
      findings.add(random, trial, speed_ups);
    }
  };
  std::vector<std::jthread> threads;
  for (int i = 0; i < options.threads; ++i) threads.emplace_back(work);
  threads.clear();
  return findings.report();
}

}  // namespace

namespace strobe::studies {

void add_effects_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* effects =
      app.add_subcommand("effects", "Models that leave effects out against full ones over random scenes");
  effects->footer(
      "Shots by the chosen and by the full model, same seed: no number may differ by more than the "
      "tolerance.\n"
      "A scene where one does is printed (TOML); its number repeats it: --first N --scenes 1.\n"
      "Example: strobe-bench effects --scenes 2000 --tolerances 0.1% 1%");
  effects->add_option("--scenes", options->scenes, "How many")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000000));
  effects->add_option("--first", options->first, "Number of the first scene")->capture_default_str();
  effects->add_option("--shots", options->shots, "Of each scene")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  effects->add_option("--threads", options->threads, "")->capture_default_str()->check(CLI::Range(1, 256));
  effects->add_option("--tolerances", options->tolerances, "As percentages or numbers")
      ->capture_default_str();
  effects->add_option("--write-scenes", options->scenes_folder,
                      "Write the scenes to this folder instead, for strobe-sim effects");
  effects->callback([options, &exit_status] { exit_status = study(*options); });
}

}  // namespace strobe::studies
