#include "host/commands/digitize_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

namespace strobe::host {

namespace {

/// A number below 1 is rather a share than a percentage, for no balls are that much alike on a photograph.
std::string size_tolerance_problem(const std::string& text) {
  double percent = 0.0;
  if (!CLI::detail::lexical_cast(text, percent)) return text + " is not a number";
  if (percent > 0.0 && percent < 1.0)
    return fmt::format("{} is read as percent and would be too small for any ball; for {} % give {}", text,
                       100.0 * percent, 100.0 * percent);
  return percent >= 1.0 && percent <= 50.0 ? std::string() : text + " is not between 1 and 50 percent";
}

void add_scale(CLI::App& command, DigitizeOptions& options) {
  command.add_option("--rig", options.rig, "rig file: ball, calibrated camera, period of the plan");
  command
      .add_option("--px-per-m", options.px_per_m,
                  "scale in the plane of flight, instead of the rig file's. Without one it is found from the "
                  "balls' outlines, at least one of which must be visible for three quarters")
      ->check(CLI::Range(1.0, 1e7));
  command
      .add_option(
          "--px-per-m-sd", options.px_per_m_sd,
          "standard deviation of a calibrated scale: speeds are then computed from the scale, not from "
          "the ball's diameter")
      ->check(CLI::Range(0.0, 1e6));
  command
      .add_option("--ball-diameter-m", options.ball_diameter_m,
                  "diameter of the ball (default: the rig file's, else 0.0651)")
      ->check(CLI::Range(0.01, 1.0));
  command.add_option("--ball-diameter-sd-m", options.ball_diameter_sd_m, "its standard deviation")
      ->check(CLI::Range(0.0, 0.1));
  command
      .add_option("--size-tolerance", options.size_tolerance_percent,
                  "by how many percent an image's diameter may differ from scale times ball diameter "
                  "(default 8; 12 where the scale is found from the photograph)")
      ->check(CLI::Validator(size_tolerance_problem, "1 - 50 PERCENT"));
}

void add_times(CLI::App& command, DigitizeOptions& options) {
  command
      .add_option("--period-ms", options.period_ms, "time between flashes, if all came when they were due")
      ->check(CLI::Range(0.01, 1000.0));
  command.add_option("--times", options.times_file,
                     "the flashes as measured, in seconds: an array [0, 0.003, ...] or an object with "
                     "flash_times_s; one line for all photographs or one for each");
}

void add_results(CLI::App& command, DigitizeOptions& options) {
  command
      .add_option("--shot-id", options.shot_id, "shot number of the first photograph; the next ones follow")
      ->check(CLI::Range(0, 1000000000));
  command.add_option("--edit", options.edit_file,
                     "a file of corrections made by hand (one photograph only; --help-all shows one)");
  command.add_option("--overlay", options.overlay,
                     "write the photograph with what was found drawn on it: a file's name, or of several "
                     "photographs a folder's");
  command.add_flag("--explain", options.explain,
                   "why each place that looked like a ball is none, and the time spent");
  command.add_flag("--json", options.json, "one frame a photograph on standard output, nothing else there");
}

}  // namespace

void add_digitize_options(CLI::App& command, DigitizeOptions& options) {
  command.add_option("IMAGE", options.images, "photographs: TIFF, PNG, JPEG, BMP, PGM")->required();
  command.option_defaults()->always_capture_default();
  add_scale(command, options);
  add_times(command, options);
  command
      .add_option("--effort", options.effort,
                  "fast, standard, or thorough (outlines measured five times over)")
      ->check(CLI::IsMember({"fast", "standard", "thorough"}));
  command
      .add_option("--direction", options.direction,
                  "direction of flight: right, left, or auto, found from the bounce")
      ->check(CLI::IsMember({"auto", "right", "left"}));
  command
      .add_option(
          "--bounce", options.bounce,
          "where there are several bounces, the one to measure, counted in time from 1 (default: the first "
          "with two images or more on either side)")
      ->check(CLI::Range(1, 100));
  add_results(command, options);
}

std::string conflict(const DigitizeOptions& options) {
  if (options.px_per_m_sd && !options.px_per_m) return "--px-per-m-sd needs --px-per-m";
  if (options.period_ms && !options.times_file.empty()) return "--period-ms and --times exclude each other";
  if (!options.edit_file.empty() && options.images.size() > 1) return "--edit is for one photograph";
  return {};
}

}  // namespace strobe::host
