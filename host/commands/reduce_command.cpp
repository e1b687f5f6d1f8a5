// strobe reduce: digitized frames to readouts.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <system_error>

#include "common/messages/json_conversions.hpp"
#include "common/reduction/legacy.hpp"
#include "common/reduction/legacy_file.hpp"
#include "common/reduction/reduce.hpp"
#include "host/commands/command.hpp"
#include "host/commands/terminal.hpp"
#include "host/config/rig_file.hpp"
#include "host/view/quantities.hpp"
#include "host/view/text.hpp"

namespace strobe::host {
namespace {

using reduction::Quantity;
using reduction::Readout;

struct ReduceOptions {
  std::vector<std::string> files;
  std::string format = "frame";
  std::string estimator = "best";
  std::string flight = "auto";
  bool json = false;
};

reduction::ReduceOptions reduction_options(const std::string& flight) {
  reduction::ReduceOptions options;
  if (flight == "none") options.effects = flight::kNoEffects;
  if (flight == "gravity") options.effects = flight::kGravityOnly;
  if (flight == "all") options.effects = flight::Effects{};
  return options;
}

/// Prints what comes and remembers what did not.
class Reducer {
 public:
  explicit Reducer(const ReduceOptions& options)
      : json_(options.json),
        estimator_(*reduction::estimator_from_name(options.estimator)),
        options_(reduction_options(options.flight)) {}

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
      const auto frame = messages::frame_from_json(line);
      frame ? put(reduction::reduce(*frame, estimator_, options_), place)
            : bad(place + frame.error().message);
    }
    if (input.bad()) return fail(file + ": cannot be read to its end");
    if (!any) bad(file + ": no frames");
    return {};
  }

  Result<void> legacy(const std::string& file) {
    const auto text = read_file(file);
    if (!text) return tl::unexpected(text.error());
    int number = 0;
    for (const auto& frame : reduction::parse_legacy(*text, file)) {
      ++number;
      if (!frame) {
        bad(frame.error().message);
      } else if (estimator_ == reduction::Estimator::legacy) {
        put(reduction::reduce_legacy(*frame), file + ": ");
      } else {
        put(reduction::reduce(reduction::frame_from_legacy(*frame), estimator_, options_),
            fmt::format("{}: frame {}: ", file, number));
      }
    }
    return {};
  }

  int conclude() const {
    if (!json_ && series_.shots() > 1) print(render_series(series_, std::nullopt, kPlainWidth));
    if (bad_ == 0) return kDone;
    return series_.shots() > 0 ? kFailed : kBadInput;
  }

 private:
  void bad(const std::string& what) {
    ++bad_;
    failed(what);
  }

  void put(const Result<Readout>& readout, const std::string& place) {
    if (!readout) return bad(place + readout.error().message);
    series_.add(*readout);
    show_progress();
    if (json_) {
      std::puts(messages::readout_to_json(*readout).c_str());
      return;
    }
    Outcome outcome;
    outcome.shot_id = readout->shot_id;
    outcome.readout = *readout;
    print(render_shot(outcome, kPlainWidth));
    if (estimator_ == reduction::Estimator::best) print({flight_line(readout->flight_effects)});
    if (readout->legacy) print(legacy_lines(*readout->legacy));
  }

  static std::string flight_line(const flight::Effects& effects) {
    std::string names;
    for (std::size_t i = 0; i < flight::kEffectNames.size(); ++i) {
      if (!(effects.*flight::kEffectMembers[i])) continue;
      names += (names.empty() ? "" : ", ") + std::string(flight::kEffectNames[i]);
    }
    return "flight fitted with: " + (names.empty() ? "nothing" : names);
  }

  /// Only a person at a terminal whose results go elsewhere sees no sign of progress otherwise.
  void show_progress() {
    constexpr std::int64_t kEvery_ns = 2'000'000'000;
    const std::int64_t now_ns = steady_now_ns();
    if (now_ns - progress_ns_ < kEvery_ns) return;
    progress_ns_ = now_ns;
    if (::isatty(STDERR_FILENO) == 1 && ::isatty(STDOUT_FILENO) == 0) {
      std::fprintf(stderr, "strobe: %d frames reduced\n", series_.shots());
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

  bool json_;
  reduction::Estimator estimator_;
  reduction::ReduceOptions options_;
  SeriesTable series_;
  int bad_ = 0;
  std::int64_t progress_ns_ = steady_now_ns();
};

int run_reduce(const ReduceOptions& options) {
  if (options.flight != "auto" && options.estimator != "best")
    return bad_input("reduce: --flight is for the best estimator");
  for (const std::string& file : options.files) {
    std::error_code error;
    if (file == "-") continue;
    if (!std::filesystem::exists(file, error)) return bad_input(file + ": no such file");
    if (std::filesystem::is_directory(file, error)) return bad_input(file + ": is a folder");
  }
  Reducer reducer(options);
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
          "lift where they matter), none, gravity, or all")
      ->check(CLI::IsMember({"auto", "none", "gravity", "all"}));
  command->add_flag("--json", options->json,
                    "one JSON object per readout on standard output, nothing else there");
  command->footer(
      "Example: strobe reduce frames.jsonl --estimator best --json\n"
      "Bad lines are named on standard error and make the exit status 1; the others are reduced. Without "
      "any\n"
      "good line it is 2.");
  command->callback([options, &exit_status] { exit_status = run_reduce(*options); });
}

}  // namespace strobe::host
