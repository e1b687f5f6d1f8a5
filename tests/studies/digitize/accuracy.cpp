#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

#include "host/digitize/overlay.hpp"
#include "sim/loading/load_scene.hpp"
#include "tests/studies/digitize/in_order.hpp"
#include "tests/studies/digitize/photographs.hpp"
#include "tests/studies/digitize/studies.hpp"
#include "tests/studies/digitize/tables.hpp"
#include "tests/support/pictures.hpp"

namespace strobe::studies::digitize {

namespace {

using strobe::digitize::Digitization;

constexpr int kNameWidth = 8;

/// Milliseconds by stage in the order of work, each the least of some rounds.
class Stages {
 public:
  void add(const std::string& stage, double ms) {
    const auto [at, fresh] = ms_.try_emplace(stage, ms);
    if (fresh) order_.push_back(stage);
    at->second = std::min(at->second, ms);
  }
  void sum(const Stages& one) {
    for (const std::string& stage : one.order_) {
      if (!ms_.contains(stage)) order_.push_back(stage);
      ms_[stage] += one.ms_.at(stage);
    }
    ++photographs_;
  }
  void print() const {
    double all_ms = 0.0;
    fmt::print("\nms a photograph, by stage:");
    for (const std::string& stage : order_) {
      fmt::print(" {} {:.1f}", stage, ms_.at(stage) / photographs_);
      all_ms += ms_.at(stage) / photographs_;
    }
    fmt::print("; in all {:.1f}\n", all_ms);
  }

 private:
  std::map<std::string, double> ms_;
  std::vector<std::string> order_;
  int photographs_ = 0;
};

/// What became of one photograph.
struct Done {
  Score score;
  TimeCount times;
  Stages stages;
  std::string csv;
};

/// Runs of thesis conditions: named for spin and angle.
bool is_thesis_condition(const std::string& name) {
  return name.starts_with("back_") || name.starts_with("top_") || name.starts_with("zero_");
}

void save(const std::string& to, const std::string& name, const KnownPhotograph& known,
          const Digitization& digitization) {
  const std::filesystem::path folder = to;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  cv::Mat picture;
  known.photograph.intensity.convertTo(picture, CV_8U, 255.0);
  strobe::testing::write_picture(folder / (name + ".png"), picture);
  if (const auto written = strobe::digitize::write_overlay(folder / (name + "_overlay.png"), known.photograph,
                                                           known.settings.map, digitization);
      !written)
    fmt::print(stderr, "strobe-bench: {}\n", written.error().message);
}

class Study {
 public:
  Study(const Options& options, std::vector<sim::Scene> scenes)
      : options_(options), scenes_(std::move(scenes)) {}

  Result<void> run() {
    if (!options_.csv.empty()) {
      csv_.open(options_.csv);
      csv_ << image_csv_head();
      if (!csv_) return fail(options_.csv + ": cannot be written");
    }
    print_score_head(kNameWidth);
    const auto shots = static_cast<std::size_t>(options_.shots.value_or(1));
    const auto done = try_in_order(
        scenes_.size() * shots, options_.jobs,
        [&](std::size_t i) {
          return one(i / shots, i % shots + static_cast<std::size_t>(options_.first_shot));
        },
        [&](std::size_t i, const Done& one_done) {
          take(one_done);
          if ((i + 1) % shots == 0) end_scene(scenes_[i / shots].name);
        });
    if (done) print_sums();
    return done;
  }

 private:
  Result<Done> one(std::size_t scene, std::size_t shot) const {
    Done done;
    auto known = known_photograph({.scene = scenes_[scene],
                                   .seed = options_.seed,
                                   .shot = static_cast<int>(shot),
                                   .kept_in = options_.keep,
                                   .independent = options_.independent,
                                   .ignore_marking = options_.ignore_marking,
                                   .shooting = shooting_of(options_, scenes_[scene])});
    if (!known) return tl::unexpected(known.error());
    known->settings.effort = options_.effort;
    done.stages.add("decode", known->decode_ms);
    Digitization digitization;
    for (int round = 0; round < options_.rounds; ++round) {
      auto result = strobe::digitize::digitize(known->photograph, known->settings);
      if (!result) return tl::unexpected(result.error());
      digitization = std::move(*result);
      for (const auto& [stage, ms] : digitization.stage_ms) done.stages.add(stage, ms);
    }
    Score& s = done.score = score(known->truth, digitization.frame, reported_places(digitization));
    score_surface(known->surface_px, digitization.frame, s);
    done.times = count_times(known->truth, known->times_s, digitization.frame);
    const std::string& name = scenes_[scene].name;
    if (!options_.csv.empty()) done.csv = image_csv(name, static_cast<int>(shot), *known, digitization);
    const bool amiss = s.found < s.airborne || s.contact_found < s.contact || s.invented > 0;
    if (amiss && !options_.save.empty())
      save(options_.save, fmt::format("{}_{}", name, shot), *known, digitization);
    return done;
  }

  void take(const Done& done) {
    of_scene_.add(done.score);
    times_.add(done.times);
    stages_.sum(done.stages);
    ++photographs_;
    csv_ << done.csv;
  }

  void end_scene(const std::string& name) {
    print_score(name, kNameWidth, of_scene_);
    all_.add(of_scene_);
    of_scene_ = {};
  }

  void print_sums() const {
    print_score("all", kNameWidth, all_);
    fmt::print(
        "\n{} photographs; of {} images with a time {} are not as far from the others' as they truly are; "
        "top of contact images {:.3f} px rms, width {:.3f} px rms\n",
        photographs_, times_.measured, times_.wrong, all_.top_px.rms(), all_.contact_width_px.rms());
    if (options_.jobs == 1) stages_.print();
  }

  const Options& options_;
  std::vector<sim::Scene> scenes_;
  std::ofstream csv_;
  Score of_scene_, all_;
  TimeCount times_;
  Stages stages_;
  int photographs_ = 0;
};

}  // namespace

Result<std::vector<std::string>> scene_names(const std::vector<std::string>& named) {
  if (!named.empty()) return named;
  auto files = sim::shipped_scene_files();
  if (!files) return tl::unexpected(files.error());
  std::vector<std::string> names;
  for (const sim::SceneFile& file : *files)
    if (is_thesis_condition(file.name)) names.push_back(file.name);
  return names;
}

Result<std::vector<sim::Scene>> load_scenes(const std::vector<std::string>& names) {
  std::vector<sim::Scene> scenes;
  for (const std::string& name : names) {
    auto scene = sim::load_scene(name);
    if (!scene) return tl::unexpected(scene.error());
    scenes.push_back(std::move(*scene));
  }
  return scenes;
}

namespace {

constexpr double kTennis_m = 0.0651;

sim::Scene with_ball(sim::Scene scene, const sim::Scene& of) {
  const double ratio = of.ball.diameter_m / scene.ball.diameter_m;
  scene.name += "+" + of.name;
  scene.ball = of.ball;
  scene.kind = of.kind;
  scene.air = of.air;
  scene.ball_appearance = of.ball_appearance;
  scene.photograph.exposure = of.photograph.exposure;
  scene.background = of.background;
  scene.camera.px_per_m /= ratio;
  for (double* length : {&scene.camera.half_width_m, &scene.camera.height_m, &scene.camera.distance_m,
                         &scene.machine.spot_sd_m, &scene.bounce.dwell_s, &scene.bounce.dwell_sd_s})
    *length *= ratio;
  scene.machine.spin_radps /= ratio;
  scene.machine.spin_sd_radps /= ratio;
  return scene;
}

}  // namespace

Result<std::vector<sim::Scene>> scenes_of(const Options& options, const std::vector<std::string>& names) {
  auto scenes = load_scenes(names);
  if (!scenes || options.ball.empty()) return scenes;
  auto of = sim::load_scene(options.ball);
  if (!of) return tl::unexpected(of.error());
  of->ball_appearance.line |= options.draw_line;
  for (sim::Scene& scene : *scenes) scene = with_ball(std::move(scene), *of);
  return scenes;
}

sim::ShootSettings shooting_of(const Options& options, const sim::Scene& scene) {
  sim::ShootSettings shooting;
  if (!options.ball.empty())
    shooting.period = from_seconds(to_seconds(shooting.period) * scene.ball.diameter_m / kTennis_m);
  return shooting;
}

Result<void> study_accuracy(const Options& options) {
  const auto names = scene_names(options.scenes);
  if (!names) return tl::unexpected(names.error());
  auto scenes = scenes_of(options, *names);
  if (!scenes) return tl::unexpected(scenes.error());
  return Study(options, std::move(*scenes)).run();
}

}  // namespace strobe::studies::digitize
