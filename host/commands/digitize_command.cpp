// strobe digitize: photographs to frames.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/command_line/command_line.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/digitize_report.hpp"
#include "host/commands/shared_options.hpp"
#include "host/commands/terminal.hpp"
#include "host/config/digitize_times.hpp"
#include "host/digitize/overlay.hpp"
#include "host/photographs/digitization_json.hpp"
#include "host/photographs/measure_photograph.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;
using digitize::DigitizeSettings;
using digitize::Photograph;

struct DigitizeOptions {
  std::vector<std::string> images;
  std::string rig;   ///< empty: none
  std::string ball;  ///< likewise
  std::optional<double> px_per_m;
  std::optional<double> px_per_m_sd;
  std::optional<double> ball_diameter_m;
  std::optional<double> ball_diameter_sd_m;
  std::optional<double> size_tolerance_percent;
  std::optional<double> period_ms;
  std::string times_file;  ///< empty: none
  std::string effort = "standard";
  std::string direction = "auto";
  std::optional<int> bounce;  ///< from 1 in time
  std::string edit_file;      ///< empty: none
  std::string overlay;        ///< empty: none
  int shot_id = 1;            ///< of the first photograph
  bool json = false;
  bool explain = false;
};

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
  command.add_option("--ball", options.ball, "kind of ball (default: the rig file's)");
  command
      .add_option("--ball-diameter-m", options.ball_diameter_m,
                  "its diameter (default: the rig file's, else 0.0651)")
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

void add_digitize_options(CLI::App& command, DigitizeOptions& options) {
  command.add_option("IMAGE", options.images, "photographs: TIFF, PNG, JPEG")->required();
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

/// What of the options given does not go together, or an empty text.
std::string conflict(const DigitizeOptions& options) {
  if (options.px_per_m_sd && !options.px_per_m) return "--px-per-m-sd needs --px-per-m";
  if (options.period_ms && !options.times_file.empty()) return "--period-ms and --times exclude each other";
  if (!options.edit_file.empty() && options.images.size() > 1) return "--edit is for one photograph";
  return {};
}

/// All that is read before the first photograph.
struct Given {
  RigFile rig;
  bool has_rig = false;
  std::vector<std::vector<double>> flash_times_s;  ///< one for all, one for each photograph, or none
  bool even = false;                               ///< those are as planned, not as measured
  std::vector<digitize::Correction> corrections;
};

Result<void> overrule(RigFile& rig, const DigitizeOptions& options) {
  if (!options.ball.empty()) {
    const auto kind = balls::load_ball_kind(options.ball);
    if (!kind) return fail("--ball: " + kind.error().message);
    rig.ball = host::settings_of(*kind);
  }
  if (options.px_per_m) {
    rig.camera.px_per_m = options.px_per_m;
    rig.camera.px_per_m_sd = options.px_per_m_sd;
  }
  if (options.ball_diameter_m) rig.ball.diameter_m = *options.ball_diameter_m;
  if (options.ball_diameter_sd_m) rig.ball.diameter_sd_m = *options.ball_diameter_sd_m;
  return {};
}

Result<void> read_times(const DigitizeOptions& options, Given& given) {
  if (!options.times_file.empty()) {
    const auto text = read_option_file("--times", options.times_file);
    if (!text) return tl::unexpected(text.error());
    auto times = parse_flash_times(*text, options.times_file);
    if (!times) return tl::unexpected(times.error());
    if (times->size() != 1 && times->size() != options.images.size())
      return fail(fmt::format("{}: {} lines for {} photographs", options.times_file, times->size(),
                              options.images.size()));
    given.flash_times_s = std::move(*times);
    return {};
  }
  if (options.period_ms) {
    given.even = true;
    given.flash_times_s = {even_flashes(*options.period_ms * 1e-3)};
  } else if (given.has_rig) {
    const ShotPlan plan = given.rig.plan.shot();
    given.even = plan.code.empty();
    given.flash_times_s = {plan_flashes(plan)};
  }
  return {};
}

Result<Given> read_given(const DigitizeOptions& options) {
  Given given;
  given.has_rig = !options.rig.empty();
  if (given.has_rig) {
    auto rig = load_rig(options.rig);
    if (!rig) return tl::unexpected(rig.error());
    given.rig = std::move(*rig);
    if (const auto warning = calibration_warning(given.rig.camera, std::chrono::system_clock::now()))
      fmt::print(stderr, "strobe: digitize: {}: {}\n", options.rig, *warning);
  }
  if (auto done = overrule(given.rig, options); !done) return tl::unexpected(done.error());
  if (auto read = read_times(options, given); !read) return tl::unexpected(read.error());
  if (!options.edit_file.empty()) {
    const auto text = read_option_file("--edit", options.edit_file);
    if (!text) return tl::unexpected(text.error());
    auto corrections = digitize::parse_corrections(*text, options.edit_file);
    if (!corrections) return tl::unexpected(corrections.error());
    given.corrections = std::move(*corrections);
  }
  return given;
}

class Digitizer {
 public:
  Digitizer(const DigitizeOptions& options, Given given) : options_(options), given_(std::move(given)) {}

  int run() {
    for (std::size_t i = 0; i < options_.images.size(); ++i) {
      const auto done = one(i);
      if (!done) {
        ++bad_;
        failed(done.error().message);
      }
      show_progress(i + 1);
    }
    if (bad_ == options_.images.size()) return kBadInput;
    return bad_ + empty_ > 0 ? kFailed : kDone;
  }

 private:
  Result<DigitizeSettings> settings_of(const Photograph& photograph, std::size_t index) const {
    auto settings = digitize_settings(given_.rig, photograph.width(), photograph.height());
    if (!settings)
      return fail((given_.has_rig ? options_.rig : photograph.name) + ": " + settings.error().message);
    if (!given_.has_rig && options_.ball.empty() && !options_.ball_diameter_sd_m)
      settings->ball_diameter_sd_m.reset();
    if (options_.size_tolerance_percent) settings->size_tolerance = *options_.size_tolerance_percent / 100.0;
    if (options_.direction != "auto") settings->leftwards = options_.direction == "left";
    settings->bounce = options_.bounce;
    if (!given_.flash_times_s.empty())
      settings->flash_times_s = given_.flash_times_s[given_.flash_times_s.size() == 1 ? 0 : index];
    settings->effort = digitize::effort_from_name(options_.effort).value();
    return settings;
  }

  Result<void> one(std::size_t index) {
    const auto photograph = digitize::load_photograph(options_.images[index]);
    if (!photograph) return tl::unexpected(photograph.error());
    const auto settings = settings_of(*photograph, index);
    if (!settings) return tl::unexpected(settings.error());
    auto found = measure(*photograph, *settings, given_.corrections, given_.rig.camera);
    if (!found) return tl::unexpected(found.error());
    found->frame.shot_id = options_.shot_id + static_cast<int>(index);
    if (given_.even) count_from_first_image(found->frame);
    tell(*found, *settings, options_.images[index]);
    if (found->frame.images.empty()) ++empty_;
    if (options_.overlay.empty()) return {};
    return digitize::write_overlay(overlay_path(index), *photograph, settings->map, *found,
                                   {.rejected = options_.explain});
  }

  void tell(const digitize::Digitization& found, const DigitizeSettings& settings,
            const std::string& photograph) const {
    if (options_.json) {
      std::puts(digitization_json(found, photograph, settings, options_.explain).c_str());
      std::fflush(stdout);
    } else {
      print(digitization_lines(found, photograph, settings));
      if (options_.explain) print(unmeasured_lines(found));
    }
    if (options_.explain) std::fputs(stages_line(found).c_str(), stderr);
  }

  fs::path overlay_path(std::size_t index) const {
    std::error_code error;
    if (options_.images.size() == 1 && !fs::is_directory(options_.overlay, error)) return options_.overlay;
    return fs::path(options_.overlay) / (fs::path(options_.images[index]).stem().string() + "_overlay.png");
  }

  /// Only where results go elsewhere does a person see no sign of progress otherwise.
  void show_progress(std::size_t done) {
    constexpr Duration kEvery = std::chrono::seconds{2};
    const HostTime now = steady_now();
    if (now - progress_ < kEvery || ::isatty(STDOUT_FILENO) == 1) return;
    progress_ = now;
    fmt::print(stderr, "strobe: {} of {} photographs digitized\n", done, options_.images.size());
  }

  const DigitizeOptions& options_;
  Given given_;
  std::size_t bad_ = 0;
  std::size_t empty_ = 0;  ///< without an image of the ball
  HostTime progress_ = steady_now();
};

int run_digitize(const DigitizeOptions& options) {
  if (const std::string wrong = conflict(options); !wrong.empty()) return bad_input("digitize: " + wrong);
  auto given = read_given(options);
  if (!given) return bad_input(given.error().message);
  std::error_code error;
  if (!options.overlay.empty() && options.images.size() > 1 && !fs::is_directory(options.overlay, error))
    return bad_input("--overlay " + options.overlay + ": must be a folder for several photographs");
  return Digitizer(options, std::move(*given)).run();
}

}  // namespace

void add_digitize_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<DigitizeOptions>();
  CLI::App* command = app.add_subcommand("digitize", "Measure the ball's images on photographs");
  add_digitize_options(*command, *options);
  command_line::for_experts(*command, {"--px-per-m-sd", "--explain", "--ball-diameter-sd-m",
                                       "--size-tolerance", "--direction", "--bounce", "--shot-id"});
  command->footer(
      "Examples: strobe digitize shot.tiff --px-per-m 4000 --period-ms 3 --overlay shot.png\n"
      "          strobe digitize shot.tiff --ball-diameter-m 0.0427 --json\n"
      "          strobe digitize shots/*.tiff --rig rig.toml --times times.jsonl --json | strobe reduce -\n"
      "          strobe digitize shot.tiff --rig rig.toml --edit corrections.toml --json\n"
      "Without --times and --period-ms the period is that of the rig file's plan; without one the images "
      "come in "
      "their order but with no times, and cannot be reduced.\n"
      "Exit status: 1 if a photograph of several could not be read, or shows no ball; 2 if none could be "
      "read.\n"
      "\f"
      "A file of corrections has tables [[add]], [[move]], [[remove]] and [surface]:\n"
      "  [[remove]]\n"
      "  at_px = [812, 640]        # the image nearest to this point of the frame (x right, y up)\n"
      "  [[move]]\n"
      "  at_image_px = [1200, 615] # ... or of the photograph (column, row from the top)\n"
      "  centre_px = [1203.5, 1224.0]\n"
      "  equator_deg = 31\n"
      "  [[add]]\n"
      "  centre_px = [1410, 1180]\n"
      "  diameter_px = 261\n"
      "  [surface]                 # the line in place of the one that was found\n"
      "  left_px = [100, 210]      # or left_image_px\n"
      "  right_px = [2300, 214]    # or right_image_px\n"
      "  sd_px = 1                 # left out: as a point by hand\n"
      "Further keys of move and add: centre_sd_px, diameter_sd_px, equator_sd_deg,\n"
      "no_equator, top_px, contact_width_px, leg, time_s; as seen on the photograph:\n"
      "centre_image_px, diameter_image_px, equator_image_deg, top_image_px.");
  command->callback([options, &exit_status] { exit_status = run_digitize(*options); });
}

}  // namespace strobe::host
