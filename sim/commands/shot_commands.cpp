#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "common/messages/json_conversions.hpp"
#include "sim/commands/commands.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/photograph/render.hpp"
#include "sim/rig/truth.hpp"
#include "sim/scene/model.hpp"

namespace strobe::sim {

namespace {

namespace fs = std::filesystem;

/// A line on stderr every two seconds, so that short runs say nothing.
class Progress {
 public:
  Progress(int shots, const char* what) : shots_(shots), what_(what) {}
  void at(int shot) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::seconds(2)) return;
    last_ = now;
    fmt::print(stderr, "strobe-sim: {} of {} {}\n", shot, shots_, what_);
  }

 private:
  int shots_;
  const char* what_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

Result<std::string> take(Shooter& shooter, const PhotographOptions& options, int shot) {
  const Scene& scene = shooter.scene();
  const SimulatedShot result = shooter.shoot(shot);
  const Appearance appearance = draw_appearance(scene, options.seed, shot);
  const auto photograph = render(scene, result.exposure, appearance);
  if (!photograph) return tl::unexpected(photograph.error());
  const std::string name = fmt::format("shot_{:04}{}", shot, extension(scene.photograph.format));
  if (auto written = write_photograph(fs::path(options.folder) / name, photograph->pixels,
                                      scene.photograph.format, std::nullopt, photograph->mosaic);
      !written)
    return tl::unexpected(written.error());
  if (!options.json) {
    fmt::print("{}/{}: {} x {}, {} bits, {} images of the ball\n", options.folder, name,
               photograph->truth.width_px, photograph->truth.height_px, scene.photograph.bits,
               photograph->truth.images.size());
  }
  return photograph_line(scene, result.exposure, shot, appearance, photograph->truth, name);
}

}  // namespace

int report_error(const std::string& message, int status) {
  fmt::print(stderr, "strobe-sim: {}\n", message);
  return status;
}

Result<Shooter> make_shooter(const SimulatedOptions& options, const Scene& scene, const Model& model,
                             const ShootSettings& settings) {
  return Shooter::make(scene, options.seed, model, settings).map_error([](Error error) {
    error.message.insert(error.message.find(':'), "-ms");  // the option's name
    return Error{"--" + error.message};
  });
}

int shoot_command(const ShootOptions& options) {
  if (options.shots < 1) return report_error("--shots: must be 1 or more", 2);
  const auto scene = load_scene(options.scene);
  if (!scene) return report_error(scene.error().message, 2);
  const auto asked = parse_model(options.model);
  if (!asked) return report_error("--model: " + asked.error().message, 2);
  Model model = *asked;
  if (const auto refusal = refusal_in_space(*scene, model); refusal && !scene->machine.planar())
    return report_error("--model: " + *refusal, 2);
  ShootSettings settings = options.settings();
  settings.perfect_digitizer = options.perfect_digitizer;
  if (const auto full = make_shooter(options, *scene, model, settings); !full)
    return report_error(full.error().message, 2);
  if (const int status = choose_model(options.tolerance, *scene, settings, model); status != 0) return status;
  auto shooter = make_shooter(options, *scene, model, settings);
  if (!shooter) return report_error(shooter.error().message, 2);
  std::ofstream truth;
  if (!options.truth_file.empty()) {
    truth.open(options.truth_file);
    if (!truth) return report_error(options.truth_file + ": cannot be written", 2);
  }
  Progress progress(options.shots, "shots");
  bool written = true;
  for (int shot = 1; shot <= options.shots && written; ++shot) {
    const SimulatedShot result = shooter->shoot(shot);
    written = std::puts(messages::frame_to_json(result.frame).c_str()) >= 0;
    if (truth.is_open()) truth << truth_line(shooter->scene(), result.exposure, shot) << '\n';
    progress.at(shot);
  }
  if (!truth.flush()) return report_error(options.truth_file + ": not everything could be written", 1);
  if (std::fflush(stdout) != 0 || !written)
    return report_error("standard output: not everything could be written", 1);
  return 0;
}

int photograph_command(const PhotographOptions& options) {
  if (options.shots < 1) return report_error("--shots: must be 1 or more", 2);
  auto scene = load_scene(options.scene);
  if (!scene) return report_error(scene.error().message, 2);
  if (options.format) scene->photograph.format = *options.format;
  if (is_mosaic(scene->photograph.format) && scene->photograph.bits == 8)
    scene->photograph.bits = kMosaicBits;
  auto shooter = make_shooter(options, *scene, Model::full(), options.settings());
  if (!shooter) return report_error(shooter.error().message, 2);
  std::error_code error;
  fs::create_directories(options.folder, error);
  const fs::path truth_path = fs::path(options.folder) / "truth.jsonl";
  std::ofstream truth(truth_path);
  if (!truth) return report_error(truth_path.string() + ": cannot be written", 2);
  Progress progress(options.shots, "photographs");
  for (int shot = 1; shot <= options.shots; ++shot) {
    const auto line = take(*shooter, options, shot);
    if (!line) return report_error(line.error().message, 1);
    truth << *line << '\n';
    if (options.json) fmt::print("{}\n", *line);
    progress.at(shot);
  }
  if (!truth.flush()) return report_error(truth_path.string() + ": not everything could be written", 1);
  if (std::fflush(stdout) != 0) return report_error("standard output: not everything could be written", 1);
  return 0;
}

}  // namespace strobe::sim
