#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "sim/commands/command_line.hpp"
#include "sim/commands/commands.hpp"
#include "sim/loading/scene_files.hpp"
#include "sim/photograph/photograph_file.hpp"
#include "sim/photograph/render.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::sim {

namespace {

namespace fs = std::filesystem;

/// A line on stderr every two seconds.
class Clock {
 public:
  void at(int shot, int shots) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::seconds(2)) return;
    last_ = now;
    fmt::print(stderr, "strobe-sim: {} of {} photographs\n", shot, shots);
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// The error of Shooter's settings with the option's name before it.
std::string option_named(std::string message) {
  message.insert(message.find(':'), "-ms");
  return "--" + message;
}

Result<std::string> take(Shooter& shooter, const PhotographOptions& options, int shot) {
  const Scene& scene = shooter.scene();
  const SimulatedShot result = shooter.shoot(shot);
  const Appearance appearance = draw_appearance(scene, options.seed, shot);
  const auto photograph = render(scene, result.exposure, appearance);
  if (!photograph) return tl::unexpected(photograph.error());
  const std::string name = fmt::format("shot_{:04}{}", shot, extension(scene.photograph.format));
  if (auto written =
          write_photograph(fs::path(options.folder) / name, photograph->pixels, scene.photograph.format);
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

int photograph_command(const PhotographOptions& options) {
  if (options.shots < 1) return report_error("--shots: must be 1 or more", 2);
  const auto scene = load_scene(options.scene);
  if (!scene) return report_error(scene.error().message, 2);
  auto shooter = Shooter::make(
      *scene, options.seed, Model::full(),
      {.period = from_milliseconds(options.period_ms), .exposure = from_milliseconds(options.exposure_ms)});
  if (!shooter) return report_error(option_named(shooter.error().message), 2);
  std::error_code error;
  fs::create_directories(options.folder, error);
  const fs::path truth_path = fs::path(options.folder) / "truth.jsonl";
  std::ofstream truth(truth_path);
  if (!truth) return report_error(truth_path.string() + ": cannot be written", 2);
  Clock clock;
  for (int shot = 1; shot <= options.shots; ++shot) {
    const auto line = take(*shooter, options, shot);
    if (!line) return report_error(line.error().message, 1);
    truth << *line << '\n';
    if (options.json) fmt::print("{}\n", *line);
    clock.at(shot, options.shots);
  }
  if (!truth.flush() || std::fflush(stdout) != 0) return report_error("not everything could be written", 1);
  return 0;
}

}  // namespace strobe::sim
