// strobe reduce: digitized frames to readouts.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "common/command_line/command_line.hpp"
#include "common/config/files.hpp"
#include "common/data/ball_kind.hpp"
#include "common/messages/json_conversions.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/reduction/legacy.hpp"
#include "common/reduction/legacy_file.hpp"
#include "common/reduction/reduce.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/terminal.hpp"
#include "host/config/rig_file.hpp"
#include "host/series/series.hpp"
#include "host/session/shot_table.hpp"
#include "host/text/text.hpp"
#include "host/view/series_json.hpp"
#include "host/view/series_view.hpp"

namespace strobe::host {
namespace {

using reduction::Quantity;
using reduction::Readout;

struct ReduceOptions {
  std::vector<std::string> files;
  std::string format = "frame";
  std::string estimator = "best";
  std::string flight = "auto";
  std::string noise = "stated";
  bool json = false;
  bool all = false;
  bool budget = false;
  std::optional<double> fastest_spin_radps;
  std::string ball;  ///< empty: as frames say
};

reduction::ReduceOptions reduction_options(const std::string& flight, const std::string& noise) {
  reduction::ReduceOptions options;
  options.noise = *reduction::noise_source_from_name(noise);
  options.likely_cause = true;
  if (flight == "none") options.effects = flight::kNoEffects;
  if (flight == "gravity") options.effects = flight::kGravityOnly;
  if (flight == "all") options.effects = flight::Effects{};
  return options;
}

/// Prints what comes and remembers what did not.
class Reducer {
 public:
  Reducer(const ReduceOptions& options, std::optional<balls::Kind> ball)
      : json_(options.json),
        all_(options.all),
        budget_(options.budget),
        estimator_(*reduction::estimator_from_name(options.estimator)),
        options_(reduction_options(options.flight, options.noise)),
        fastest_spin_radps_(options.fastest_spin_radps),
        ball_(std::move(ball)) {}

  Result<void> frames(const std::string& file) {
    std::ifstream opened;
    if (file != "-") opened.open(file);
    std::istream& input = file == "-" ? std::cin : opened;
    if (!input) return fail(file + ": cannot be read");
    std::string line;
    bool any = false;
    for (int number = 1; std::getline(input, line); ++number) {
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      any = true;
      const std::string place = fmt::format("{}:{}: ", file, number);
      auto frame = messages::frame_from_json(line);
      frame ? reduce(std::move(*frame), place) : bad(place + frame.error().message);
    }
    if (input.bad()) return fail(file + ": cannot be read to its end");
    if (!any) bad(file + ": no frames");
    return {};
  }

  Result<void> legacy(const std::string& file) {
    const auto text = config::read_file(file);
    if (!text) return tl::unexpected(text.error());
    int number = 0;
    for (const auto& frame : reduction::parse_legacy(*text, file)) {
      ++number;
      if (!frame) {
        bad(frame.error().message);
      } else if (estimator_ == reduction::Estimator::legacy) {
        put(reduction::reduce_legacy(*frame), file + ": ");
      } else {
        reduce(reduction::frame_from_legacy(*frame), fmt::format("{}: frame {}: ", file, number));
      }
    }
    return {};
  }

  int conclude() const {
    if (!json_ && series_.counted() > 1) print(render_series(series_, std::nullopt, kPlainWidth, all_));
    if (bad_ == 0 && with_numbers_ > 0) return kDone;
    return reduced_ > 0 ? kFailed : kBadInput;
  }

 private:
  void bad(const std::string& what) {
    ++bad_;
    failed(what);
  }

  void reduce(reduction::Frame frame, const std::string& place) {
    if (!frame.fastest_spin_radps) frame.fastest_spin_radps = fastest_spin_radps_;
    if (ball_) {
      if (!frame.ball_mass_kg) frame.ball_mass_kg = ball_->mass_kg.value;
      if (!frame.ball_alpha) frame.ball_alpha = ball_->alpha.value;
      if (!frame.ball_alpha_sd) frame.ball_alpha_sd = ball_->alpha.sd;
      if (!frame.air_law) frame.air_law = ball_->air;
    }
    put(reduction::reduce(frame, estimator_, options_), place, &frame);
  }

  /// A person's series tells what its shots share; a program asks for it.
  reduction::Budget budget_of(const reduction::Frame* frame) const {
    const bool asked = !json_ || budget_;
    if (!asked || frame == nullptr || estimator_ == reduction::Estimator::legacy) return {};
    auto budget = reduction::uncertainty_budget(*frame, estimator_, options_);
    return budget ? std::move(*budget) : reduction::Budget{};
  }

  /// Frames of one scale and one ball are taken to have the same calibration and ball.
  void add_to_series(const Readout& readout, const reduction::Budget& budget, const reduction::Frame* frame) {
    Shot shot;
    shot.name = std::to_string(readout.shot_id);
    shot.readout = readout;
    shot.budget = budget;
    if (frame != nullptr) {
      shot.calibration =
          fmt::format("{} {}", frame->px_per_m.value_or(0.0), frame->px_per_m_sd.value_or(0.0));
      const auto name = readout.record.find("ball_name");
      shot.ball = fmt::format("{} {}", frame->ball_diameter_m, frame->ball_diameter_sd_m.value_or(0.0));
      if (name != readout.record.end()) shot.ball += "\n" + name->second;
    }
    series_.add(shot);
  }

  void put(const Result<Readout>& readout, const std::string& place,
           const reduction::Frame* frame = nullptr) {
    if (!readout) return bad(place + readout.error().message);
    ++reduced_;
    if (readout->value != reduction::Quantities{} || readout->launch) ++with_numbers_;
    const reduction::Budget budget = budget_of(frame);
    if (!json_ && !readout->launch) add_to_series(*readout, budget, frame);
    show_progress();
    if (json_) return put_json(*readout, budget);
    Shot shot_result;
    shot_result.shot_id = readout->shot_id;
    shot_result.readout = *readout;
    print(render_shot(shot_result, kPlainWidth, all_));
    if (all_ && readout->method == "best") print({flight_line(readout->flight_effects)});
    if (readout->residual_ratios.all) print({residual_line(readout->residual_ratios)});
    if (budget_) print_budget(budget, *readout);
    if (readout->legacy) print(legacy_lines(*readout->legacy));
  }

  void print_budget(const reduction::Budget& budget, const Readout& readout) const {
    for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      if (!readout.value[q] || !(all_ || is_essential(q))) continue;
      print(render_budget(fmt::format("shot {}", readout.shot_id), budget_lines(budget, q), q, kPlainWidth));
    }
  }

  void put_json(const Readout& readout, const reduction::Budget& budget) const {
    std::string line = messages::readout_to_json(readout);
    if (budget_) {
      line.back() = ',';
      line += "\"budget\":" + messages::json_text(budget_json(budget, readout)) + "}";
    }
    std::puts(line.c_str());
  }

  static std::string flight_line(const flight::Effects& effects) {
    std::string names;
    for (std::size_t i = 0; i < flight::kEffectNames.size(); ++i) {
      if (!(effects.*flight::kEffectMembers[i])) continue;
      names += (names.empty() ? "" : ", ") + std::string(flight::kEffectNames[i]);
    }
    return "flight fitted with: " + (names.empty() ? "nothing" : names);
  }

  static std::string residual_line(const reduction::ResidualRatios& ratios) {
    std::string kinds;
    for (std::size_t i = 0; i < reduction::kMeasurementKindCount; ++i) {
      if (!ratios.by_kind[i]) continue;
      kinds += fmt::format("{}{} {:.2f}", kinds.empty() ? "" : ", ", reduction::kMeasurementKindNames[i],
                           *ratios.by_kind[i]);
    }
    return fmt::format("residuals over stated noise: {:.2f} ({})", *ratios.all, kinds);
  }

  /// Only a person at a terminal whose results go elsewhere sees no sign of progress otherwise.
  void show_progress() {
    constexpr Duration kEvery = std::chrono::seconds{2};
    const HostTime now = steady_now();
    if (now - progress_ < kEvery) return;
    progress_ = now;
    if (::isatty(STDERR_FILENO) == 1 && ::isatty(STDOUT_FILENO) == 0) {
      std::fprintf(stderr, "strobe: %d frames reduced\n", reduced_);
    }
  }

  static std::vector<std::string> legacy_lines(const reduction::LegacyDetail& detail) {
    std::vector<std::string> lines{"from the first two and the last two images:"};
    for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
      const auto& value = detail.far[static_cast<Quantity>(i)];
      if (value) lines.push_back(left(kQuantityLabels[i].words, 17) + right(rounded(*value, 0.0), 10));
    }
    if (!detail.contact.empty()) lines.push_back("contact: height_cm, fractions of time, x, y, rotation");
    for (const auto& image : detail.contact) {
      lines.push_back(fmt::format("{:10.3f}{:10.4f}{:10.4f}{:10.4f}{:10.4f}", image.height_cm,
                                  image.time_fraction, image.x_fraction, image.y_fraction,
                                  image.rotation_fraction));
    }
    return lines;
  }

  bool json_, all_, budget_;
  reduction::Estimator estimator_;
  reduction::ReduceOptions options_;
  std::optional<double> fastest_spin_radps_;
  std::optional<balls::Kind> ball_;
  Series series_;
  int reduced_ = 0, with_numbers_ = 0;
  int bad_ = 0;
  HostTime progress_ = steady_now();
};

int run_reduce(const ReduceOptions& options) {
  if (options.flight != "auto" && options.estimator != "best")
    return bad_input("reduce: --flight needs --estimator best");
  if (options.budget && options.format == "legacy") return bad_input("reduce: --budget needs --format frame");
  if (options.noise != "stated" && options.estimator != "best")
    return bad_input("reduce: --noise residuals needs --estimator best");
  for (const std::string& file : options.files) {
    std::error_code error;
    if (file == "-") continue;
    if (!std::filesystem::exists(file, error)) return bad_input(file + ": no such file");
    if (std::filesystem::is_directory(file, error)) return bad_input(file + ": is a folder");
  }
  std::optional<balls::Kind> ball;
  if (!options.ball.empty()) {
    auto read = balls::load_ball_kind(options.ball);
    if (!read) return bad_input("reduce: --ball: " + read.error().message);
    ball = *std::move(read);
  }
  Reducer reducer(options, std::move(ball));
  for (const std::string& file : options.files) {
    const auto read = options.format == "legacy" ? reducer.legacy(file) : reducer.frames(file);
    if (!read) return bad_input(read.error().message);
  }
  return reducer.conclude();
}

}  // namespace

void add_reduce_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<ReduceOptions>();
  CLI::App* command = app.add_subcommand("reduce", "Reduce digitized frames to rebounds");
  command
      ->add_option("FILE", options->files,
                   "frames, one JSON object a line, or the thesis's text; - is standard input")
      ->required();
  command->add_option("--format", options->format, "frame (default) or legacy")
      ->check(CLI::IsMember({"frame", "legacy"}));
  command->add_option("--estimator", options->estimator, "best (default), two-point or legacy")
      ->check(CLI::IsMember({"best", "two-point", "legacy"}));
  command
      ->add_option(
          "--flight", options->flight,
          "what the best estimator fits the flight with: auto (default: gravity, and drag and Magnus "
          "lift where they matter; spins corrected for the air's friction), none, gravity (neither corrects "
          "spins), or all")
      ->check(CLI::IsMember({"auto", "none", "gravity", "all"}));
  command
      ->add_option(
          "--noise", options->noise,
          "where the noise of the measurements is taken from: stated (default: the sds that the frame "
          "states) or "
          "residuals (those are relative weights only; the noise of each kind of measurement is estimated "
          "from the shot's own residuals, and sds are widened by Student's t)")
      ->check(CLI::IsMember({"stated", "residuals"}));
  command
      ->add_option("--fastest-spin-radps", options->fastest_spin_radps,
                   "the fastest spin that the ball can have before the bounce, of frames that state none")
      ->check(CLI::Range(1.0, 1e6));
  command->add_option(
      "--ball", options->ball,
      "kind of ball (strobe ball lists them), for mass, inertia, drag and lift of frames that "
      "state none");
  command->add_flag(
      "--budget", options->budget,
      "what each number's uncertainty is made of: source, type (A or B), sensitivity, effect, share");
  command->add_flag("--all", options->all, "experts' numbers as well: slip, flight effects");
  command->add_flag("--json", options->json,
                    "one JSON object per readout on standard output, nothing else there");
  command_line::for_experts(*command, {"--noise", "--all"});
  command->footer(
      "Example: strobe reduce frames.jsonl --estimator best --json\n"
      "Bad lines are named on standard error and make the exit status 1; the others are reduced. Without "
      "any good line it is 2, and 1 where none gave a number.");
  command->callback([options, &exit_status] { exit_status = run_reduce(*options); });
}

}  // namespace strobe::host
