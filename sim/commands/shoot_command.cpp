#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "common/messages/json_conversions.hpp"
#include "sim/commands/command_line.hpp"
#include "sim/commands/commands.hpp"
#include "sim/loading/scene_files.hpp"
#include "sim/rig/truth.hpp"
#include "sim/scene/model_text.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::sim {

namespace {

/// A line on stderr every two seconds, so that short runs say nothing.
class Progress {
 public:
  explicit Progress(int shots) : shots_(shots) {}
  void at(int shot) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::seconds(2)) return;
    last_ = now;
    fmt::print(stderr, "strobe-sim: {} of {} shots\n", shot, shots_);
  }

 private:
  int shots_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

Result<Shooter> prepare(const ShootOptions& options, const Scene& scene, const Model& model) {
  return Shooter::make(scene, options.seed, model,
                       {.period = from_milliseconds(options.period_ms),
                        .exposure = from_milliseconds(options.exposure_ms),
                        .perfect_digitizer = options.perfect_digitizer})
      .map_error([](Error error) {
        error.message.insert(error.message.find(':'), "-ms");  // the option's name
        return Error{"--" + error.message};
      });
}

/// 0, or the exit status after the error message.
int choose_model(const ShootOptions& options, const Scene& scene, Model& model) {
  if (options.tolerance.empty() && !options.deadline_us) return 0;
  const auto demand = parse_requirement(options.tolerance, options.deadline_us, scene);
  if (!demand) return report_error(demand.error().message, 2);
  const auto chosen = choose(scene, *demand,
                             {.period = from_milliseconds(options.period_ms),
                              .exposure = from_milliseconds(options.exposure_ms),
                              .perfect_digitizer = options.perfect_digitizer});
  if (!chosen) return report_error(chosen.error().message, 1);
  fmt::print(stderr, "strobe-sim: {}\n", explanation(*chosen));
  model = chosen->plan.model;
  return 0;
}

}  // namespace

int shoot_command(const ShootOptions& options) {
  if (options.shots < 1) return report_error("--shots: must be 1 or more", 2);
  const auto scene = load_scene(options.scene);
  if (!scene) return report_error(scene.error().message, 2);
  const auto asked = parse_model(options.model);
  if (!asked) return report_error("--model: " + asked.error().message, 2);
  Model model = *asked;
  if (const auto full = prepare(options, *scene, model); !full) return report_error(full.error().message, 2);
  if (const int status = choose_model(options, *scene, model); status != 0) return status;
  auto shooter = prepare(options, *scene, model);
  if (!shooter) return report_error(shooter.error().message, 2);
  std::ofstream truth;
  if (!options.truth_file.empty()) {
    truth.open(options.truth_file);
    if (!truth) return report_error(options.truth_file + ": cannot be written", 2);
  }
  Progress progress(options.shots);
  bool written = true;
  for (int shot = 1; shot <= options.shots && written; ++shot) {
    const SimulatedShot result = shooter->shoot(shot);
    written = std::puts(messages::frame_to_json(result.frame).c_str()) >= 0;
    if (truth.is_open()) truth << truth_line(shooter->scene(), result.exposure, shot) << '\n';
    progress.at(shot);
  }
  written = std::fflush(stdout) == 0 && written;
  if (!truth.flush() || !written) return report_error("not everything could be written", 1);
  return 0;
}

}  // namespace strobe::sim
