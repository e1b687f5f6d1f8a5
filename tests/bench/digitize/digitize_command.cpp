// strobe-bench digitize: rendered photographs digitized, held against the truth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "common/units/angles.hpp"
#include "host/digitize/overlay.hpp"
#include "sim/live/scene_files.hpp"
#include "tests/bench/command.hpp"
#include "tests/bench/digitize/hough.hpp"
#include "tests/bench/digitize/photographs.hpp"

namespace {

using namespace strobe;
using namespace strobe::bench::digitize;
using strobe::digitize::Digitization;
using strobe::digitize::Effort;

struct Options {
  std::vector<std::string> scenes;
  int shots = 1;
  std::uint64_t seed = 1;
  Effort effort = Effort::standard;
  int rounds = 2;
  bool hough = true;
  std::string save;
};

/// Milliseconds by stage in the order of work, each the least of some rounds, summed over photographs.
class Stages {
 public:
  void add(const std::map<std::string, double>& least, const std::vector<std::string>& order) {
    for (const std::string& stage : order) {
      if (!sums_.contains(stage)) order_.push_back(stage);
      sums_[stage] += least.at(stage);
    }
    ++photographs_;
  }

  void print() const {
    double all_ms = 0.0;
    fmt::print("\nms a photograph, by stage:");
    for (const std::string& stage : order_) {
      fmt::print(" {} {:.1f}", stage, sums_.at(stage) / photographs_);
      all_ms += sums_.at(stage) / photographs_;
    }
    fmt::print("; in all {:.1f}\n", all_ms);
  }

 private:
  std::map<std::string, double> sums_;
  std::vector<std::string> order_;
  int photographs_ = 0;
};

struct Hough {
  HoughSettings settings;
  Score score;
  double sum_ms = 0.0;

  int of() const { return score.airborne + score.contact; }
  int found() const { return score.found + score.contact_found; }
  double recall() const { return static_cast<double>(found()) / std::max(1, of()); }
  double precision() const { return static_cast<double>(found()) / std::max(1, found() + score.invented); }
  double f1() const { return 2.0 * found() / std::max(1, of() + found() + score.invented); }
};

struct Outcome {
  Score score;
  int measured_times = 0;
  int wrong_times = 0;  ///< taken for another flash's
  Stages stages;
  int photographs = 0;
};

/// Runs of thesis conditions: named for spin and angle.
bool is_thesis_condition(const std::string& name) {
  return name.starts_with("back_") || name.starts_with("top_") || name.starts_with("zero_");
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// Which flash was the first cannot be seen on images at even intervals, so that all may be off by the same
/// time: the middle one of the differences is left out.
void count_times(const KnownPhotograph& known, const reduction::Frame& frame, Outcome& outcome) {
  std::vector<double> late_s;
  for (const reduction::BallImage& image : frame.images) {
    if (!std::isfinite(image.time_s)) continue;
    for (std::size_t i = 0; i < known.truth.size(); ++i) {
      const double distance_px = std::hypot(image.centre_px.x - known.truth[i].centre_px.x,
                                            image.centre_px.y - known.truth[i].centre_px.y);
      if (distance_px <= 0.1 * image.diameter_px) late_s.push_back(image.time_s - known.times_s[i]);
    }
  }
  if (late_s.empty()) return;
  std::ranges::sort(late_s);
  const double common_s = late_s[late_s.size() / 2];
  outcome.measured_times += static_cast<int>(late_s.size());
  outcome.wrong_times += static_cast<int>(
      std::ranges::count_if(late_s, [&](double late) { return std::abs(late - common_s) > 1e-3; }));
}

void save(const Options& options, const std::string& name, const KnownPhotograph& known,
          const Digitization& digitization) {
  namespace fs = std::filesystem;
  fs::create_directories(options.save);
  const fs::path folder = options.save;
  cv::Mat picture;
  known.photograph.light.convertTo(picture, CV_8U, 255.0);
  cv::imwrite((folder / (name + ".png")).string(), picture);
  if (const auto written = strobe::digitize::write_overlay(folder / (name + "_overlay.png"), known.photograph,
                                                           known.settings.map, digitization);
      !written)
    fmt::print(stderr, "strobe-bench: {}\n", written.error().message);
}

Result<Score> digitize_one(const Options& options, const std::string& name, KnownPhotograph& known,
                           Outcome& outcome) {
  known.settings.effort = options.effort;
  std::map<std::string, double> least{{"decode", known.decode_ms}};
  std::vector<std::string> order{"decode"};
  Digitization digitization;
  for (int round = 0; round < options.rounds; ++round) {
    auto result = strobe::digitize::digitize(known.photograph, known.settings);
    if (!result) return tl::unexpected(result.error());
    digitization = std::move(*result);
    for (const auto& [stage, ms] : digitization.stage_ms) {
      const auto [at, fresh] = least.try_emplace(stage, ms);
      if (fresh) order.push_back(stage);
      at->second = std::min(at->second, ms);
    }
  }
  outcome.stages.add(least, order);
  ++outcome.photographs;
  const Score one = score(known.truth, digitization.frame);
  outcome.score.add(one);
  count_times(known, digitization.frame, outcome);
  const bool amiss = one.found < one.airborne || one.contact_found < one.contact || one.invented > 0;
  if (amiss && !options.save.empty()) save(options, name, known, digitization);
  return one;
}

void try_hough(const KnownPhotograph& known, std::vector<Hough>& trials) {
  for (Hough& trial : trials) {
    const auto start = std::chrono::steady_clock::now();
    const reduction::Frame frame = hough_circles(known.photograph, known.settings, trial.settings);
    trial.sum_ms += milliseconds_since(start);
    trial.score.add(score(known.truth, frame));
  }
}

double centre_rms(const Score& s) {
  return std::sqrt(0.5 * (s.x_px.squares + s.y_px.squares) / s.x_px.count);
}

void print_head() {
  fmt::print(
      "{:<8} {:>9} {:>8} {:>8} {:>4} | {:>6} {:>5} {:>6} | {:>6} {:>5} {:>6} | {:>9} {:>6} {:>5} {:>6} | "
      "{:>6}\n",
      "", "airborne", "contact", "invented", "cut", "centre", "norm.", "worst", "diam.", "norm.", "worst",
      "equators", "deg", "norm.", "worst", "top px");
}

void print_score(const std::string& name, const Score& s) {
  fmt::print(
      "{:<8} {:>4}/{:<4} {:>4}/{:<3} {:>8} {:>4} | {:>6.3f} {:>5.2f} {:>6.2f} | {:>6.3f} {:>5.2f} {:>6.2f} | "
      "{:>4}/{:<4} {:>6.3f} {:>5.2f} {:>6.2f} | {:>6.2f}\n",
      name, s.found, s.airborne, s.contact_found, s.contact, s.invented, s.cut, centre_rms(s),
      s.mahalanobis.normalized(), std::max(s.x_px.largest, s.y_px.largest), s.diameter_px.rms(),
      s.diameter_px.normalized(), s.diameter_px.largest, s.lines_found, s.lines, degrees(s.equator_rad.rms()),
      s.equator_rad.normalized(), degrees(s.equator_rad.largest), s.top_px.rms());
  std::fflush(stdout);
}

void print_hough(const std::vector<Hough>& trials, int photographs) {
  const Hough& best = *std::ranges::max_element(trials, {}, &Hough::f1);
  fmt::print(
      "\nHoughCircles, the best of {} settings ({}): recall {:.1f} %, precision {:.1f} %, {} of {} found, {} "
      "invented, centre {:.2f} px rms, diameter {:.2f} px rms, {:.1f} ms a photograph\n",
      trials.size(), text_of(best.settings), 100.0 * best.recall(), 100.0 * best.precision(), best.found(),
      best.of(), best.score.invented, centre_rms(best.score), best.score.diameter_px.rms(),
      best.sum_ms / photographs);
}

Result<std::vector<std::string>> scene_names(const Options& options) {
  if (!options.scenes.empty()) return options.scenes;
  auto files = sim::shipped_scene_files();
  if (!files) return tl::unexpected(files.error());
  std::vector<std::string> names;
  for (const sim::SceneFile& file : *files)
    if (is_thesis_condition(file.name)) names.push_back(file.name);
  return names;
}

Result<void> study(const Options& options, const std::vector<std::string>& names, Outcome& all,
                   std::vector<Hough>& hough) {
  print_head();
  for (const std::string& name : names) {
    const auto scene = sim::load_scene(name);
    if (!scene) return tl::unexpected(scene.error());
    Score of_scene;
    for (int shot = 1; shot <= options.shots; ++shot) {
      auto known = known_photograph(*scene, options.seed, shot);
      if (!known) return tl::unexpected(known.error());
      const auto one = digitize_one(options, fmt::format("{}_{}", name, shot), *known, all);
      if (!one) return tl::unexpected(one.error());
      of_scene.add(*one);
      if (options.hough) try_hough(*known, hough);
    }
    print_score(name, of_scene);
  }
  return {};
}

int run(const Options& options) {
  const auto names = scene_names(options);
  if (!names) {
    fmt::print(stderr, "strobe-bench: {}\n", names.error().message);
    return 2;
  }
  Outcome all;
  std::vector<Hough> hough;
  for (const HoughSettings& settings : hough_trials()) hough.push_back({settings, {}, 0.0});
  if (const auto done = study(options, *names, all, hough); !done) {
    fmt::print(stderr, "strobe-bench: {}\n", done.error().message);
    return 1;
  }
  print_score("all", all.score);
  fmt::print(
      "\n{} photographs; of {} images with a time {} are not as far from the others' as they truly are\n",
      all.photographs, all.measured_times, all.wrong_times);
  all.stages.print();
  if (options.hough) print_hough(hough, all.photographs);
  return 0;
}

}  // namespace

namespace strobe::bench {

void add_digitize_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("digitize", "Rendered photographs digitized, held against the truth");
  command->footer(
      "By scene: images found of those there, in the air and in contact, invented ones, those cut off by "
      "the\n"
      "border; rms errors of centre [px], diameter [px], equator [degrees], contact top [px], the same over "
      "the\n"
      "stated standard deviations (1: they are true), and the largest. Times are the least of the rounds.\n"
      "Example: strobe-bench digitize --shots 5 --effort standard --save /tmp/amiss");
  command->add_option("scenes", options->scenes, "Scenes; without, the thesis's 21 conditions");
  command->add_option("--shots", options->shots, "Photographs of each")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  command->add_option("--seed", options->seed, "Of the simulation")->capture_default_str();
  const std::map<std::string, Effort> efforts{
      {"fast", Effort::fast}, {"standard", Effort::standard}, {"thorough", Effort::thorough}};
  command->add_option("--effort", options->effort, "fast, standard or thorough")
      ->transform(CLI::CheckedTransformer(efforts));
  command->add_option("--rounds", options->rounds, "Digitized so often; the least time counts")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command->add_flag("!--no-hough", options->hough, "Leave out HoughCircles");
  command->add_option(
      "--save", options->save,
      "Folder for photographs with images missed or invented, and what was digitized on them");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::bench
