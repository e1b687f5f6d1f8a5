// strobe camera: the camera by itself: which there are, how it is set, how its pictures are lit.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/command_line/command_line.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/commands/camera_talk.hpp"
#include "host/commands/command.hpp"
#include "host/commands/digitize_report.hpp"
#include "host/commands/shared_options.hpp"
#include "host/commands/terminal.hpp"
#include "host/digitize/overlay.hpp"
#include "host/light/advice.hpp"
#include "host/photographs/measure_photograph.hpp"
#include "host/text/text.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct CameraOptions {
  bool list = false, snap = false, watch = false;
  std::string rig;                    ///< empty: none
  std::string snap_file;              ///< empty: the picture is not kept
  std::string photographs;            ///< empty: as the rig file says
  std::vector<std::string> pictures;  ///< to advise on
  std::string overlay, effort = "standard";
  double exposure_ms = 10.0;
  int count = 0;  ///< pictures of --watch; 0: until it is ended
  bool json = false, plain = false;
};

std::string conflict(const CameraOptions& options) {
  const int asked = options.list + options.snap + options.watch + !options.pictures.empty();
  if (asked > 1) return "--list, --snap, --watch and --advise exclude each other";
  if (asked == 0 && options.rig.empty()) return "give --rig, --list or --advise";
  if ((options.snap || options.watch) && options.rig.empty() && options.photographs.empty())
    return "--snap and --watch need --rig or --photographs";
  if (!options.overlay.empty() && !options.snap && options.pictures.empty())
    return "--overlay is for --snap and --advise";
  return {};
}

int list(const CameraOptions& options) {
  const FoundCameras found = find_cameras();
  for (const std::string& problem : found.problems) fmt::print(stderr, "strobe: camera: {}\n", problem);
  if (!options.json && !found.cameras.empty())
    fmt::print("{:<8} {:<18} {:<24} {:<16} {}\n", "kind", "maker", "model", "serial", "address");
  for (const auto& [kind, camera] : found.cameras) {
    if (options.json)
      fmt::print("{}\n", messages::json_text(ordered_json{{"kind", kind},
                                                          {"vendor", camera.vendor},
                                                          {"model", camera.model},
                                                          {"serial", camera.serial},
                                                          {"firmware", camera.firmware},
                                                          {"address", camera.address}}));
    else
      fmt::print("{:<8} {:<18} {:<24} {:<16} {}\n", kind, camera.vendor, camera.model, camera.serial,
                 camera.address);
  }
  if (found.cameras.empty()) return failed("camera: none is found");
  return kDone;
}

/// Of what was asked for, or is otherwise than it should be, a line each.
std::vector<std::string> settings_lines(const tether::OpenedEvent& opened) {
  constexpr std::size_t kName = 26, kValue = 16;
  std::vector<std::string> lines{left("setting", kName) + left("asked", kValue) + left("is", kValue) +
                                 "remark"};
  for (const tether::Setting& setting : opened.settings) {
    std::string remark = setting.state == tether::SettingState::read ? "" : std::string(name(setting.state));
    if (setting.state == tether::SettingState::as_asked) remark = "as asked";
    if (!setting.remark.empty()) remark += (remark.empty() ? "" : ": ") + setting.remark;
    lines.push_back(left(setting.name, kName) + left(setting.asked, kValue) + left(setting.is, kValue) +
                    remark);
  }
  return lines;
}

bool prevents(const tether::OpenedEvent& opened) {
  return std::ranges::any_of(opened.problems, &tether::Problem::prevents);
}

int check(const CameraOptions& options, const PictureSource& source) {
  const tether::OpenedEvent* opened = source.opened();
  if (!opened) {
    if (options.json)
      fmt::print("{}\n", messages::json_text(ordered_json{{"kind", "folder"}, {"folder", source.name()}}));
    else
      fmt::print("photographs are expected in {}: nothing of that camera can be checked from here\n",
                 source.name());
    return kDone;
  }
  if (options.json) {
    fmt::print("{}\n", tether::to_line(*opened));
    return prevents(*opened) ? kFailed : kDone;
  }
  fmt::print("{} at {}, exposes {}{}\n", source.name(), opened->camera.address, opened->exposure,
             opened->has_clock ? "; tells when" : "; does not tell when");
  print(settings_lines(*opened));
  for (const tether::Problem& problem : opened->problems)
    fmt::print("{} {}\n", problem.prevents ? "WRONG:  " : "look at:", problem.text);
  return prevents(*opened) ? kFailed : kDone;
}

/// A picture looked at.
struct Looked {
  MeasuredPhotograph measured;
  light::LightMeasures light;
  std::vector<light::Advice> advice;
};

class Looking {
 public:
  Looking(const CameraOptions& options, RigFile rig) : options_(options), rig_(std::move(rig)) {}
  const RigFile& rig() const { return rig_; }

  Result<Looked> look(const fs::path& file) const {
    MeasureSettings settings;
    settings.effort = digitize::effort_from_name(options_.effort).value();
    auto measured = measure_photograph(file, rig_, settings);
    if (!measured) return fail(measured.error().message);
    Looked looked{std::move(*measured), {}, {}};
    looked.light =
        light::measure_light(looked.measured.photograph, looked.measured.settings.map, looked.measured.found);
    looked.advice = light::advise(looked.light);
    return looked;
  }

  void tell(const Looked& looked, const std::string& name) const {
    if (options_.json) {
      ordered_json json{{"photograph", name}};
      json.update(ordered_json::parse(light::advice_json(looked.light, looked.advice)));
      std::puts(messages::json_text(json).c_str());
    } else {
      print(lines(looked, name));
    }
    std::fflush(stdout);
  }

  static std::vector<std::string> lines(const Looked& looked, const std::string& name) {
    std::vector<std::string> lines{fmt::format("{}: {} images of the ball, light: {}", name,
                                               looked.light.images,
                                               light::name(light::worst(looked.advice)))};
    for (std::string& line : light::advice_lines(looked.advice)) lines.push_back("  " + std::move(line));
    return lines;
  }

  Result<void> draw(const Looked& looked, const fs::path& overlay) const {
    return digitize::write_overlay(overlay, looked.measured.photograph, looked.measured.settings.map,
                                   looked.measured.found);
  }

 private:
  const CameraOptions& options_;
  RigFile rig_;
};

int status_of(light::Verdict worst) { return worst == light::Verdict::wrong ? kFailed : kDone; }

int advise(const CameraOptions& options, const Looking& looking) {
  std::size_t bad = 0;
  light::Verdict worst = light::Verdict::ok;
  for (const std::string& file : options.pictures) {
    const auto looked = looking.look(file);
    if (!looked) {
      failed(looked.error().message);
      ++bad;
      continue;
    }
    worst = std::max(worst, light::worst(looked->advice));
    looking.tell(*looked, file);
    if (options.overlay.empty()) continue;
    const fs::path overlay =
        options.pictures.size() == 1
            ? fs::path(options.overlay)
            : fs::path(options.overlay) / (fs::path(file).stem().string() + "_overlay.png");
    if (const auto drawn = looking.draw(*looked, overlay); !drawn) return failed(drawn.error().message);
  }
  if (bad == options.pictures.size()) return kBadInput;
  return bad > 0 ? kFailed : status_of(worst);
}

int snap(const CameraOptions& options, const Looking& looking, PictureSource& source) {
  const auto file = source.next(1e-3 * options.exposure_ms);
  if (!file) return failed("camera: " + file.error().message);
  std::string name = file->filename().string();
  if (!options.snap_file.empty()) {
    name = options.snap_file;
    std::error_code error;
    fs::copy_file(*file, name, fs::copy_options::overwrite_existing, error);
    if (error) return failed(name + ": cannot be written: " + error.message());
  }
  const auto looked = looking.look(*file);
  if (!looked) return failed("camera: " + looked.error().message);
  looking.tell(*looked, name);
  if (!options.json) print(digitization_lines(looked->measured.found, name, looked->measured.settings));
  if (options.overlay.empty()) return status_of(light::worst(looked->advice));
  if (const auto drawn = looking.draw(*looked, options.overlay); !drawn) return failed(drawn.error().message);
  if (!options.json) fmt::print("drawn on {}\n", options.overlay);
  return status_of(light::worst(looked->advice));
}

/// One picture after the other, until a person ends it.
int watch(const CameraOptions& options, const Looking& looking, PictureSource& source) {
  const bool paints = !options.json && !options.plain && Screen::possible();
  std::optional<Screen> screen;
  if (paints) screen.emplace();
  for (int seen = 1; options.count == 0 || seen <= options.count; ++seen) {
    const auto file = source.next(1e-3 * options.exposure_ms);
    if (interrupted()) break;
    if (!file) {
      screen.reset();
      return failed("camera: " + file.error().message);
    }
    const auto looked = looking.look(*file);
    const std::string name = file->filename().string();
    if (!screen) {
      if (looked)
        looking.tell(*looked, name);
      else
        failed(looked.error().message);
    } else {
      std::vector<std::string> lines{source.name() + fmt::format(", picture {} (Ctrl-C ends)", seen), ""};
      for (std::string& line : looked ? Looking::lines(*looked, name) : std::vector{looked.error().message})
        lines.push_back(std::move(line));
      screen->paint(lines);
    }
    std::error_code error;
    if (source.opened()) fs::remove(*file, error);
  }
  return kDone;
}

int run_camera(const CameraOptions& options) {
  if (const std::string wrong = conflict(options); !wrong.empty()) return bad_input("camera: " + wrong);
  catch_signals();
  if (options.list) return list(options);
  RigFile rig;
  if (!options.rig.empty()) {
    auto read = load_rig(options.rig);
    if (!read) return bad_input(read.error().message);
    rig = std::move(*read);
  }
  if (!options.photographs.empty()) {
    rig.camera.connection.kind = CameraKind::folder;
    rig.camera.folder = options.photographs;
  }
  const Looking looking(options, std::move(rig));
  if (!options.pictures.empty()) return advise(options, looking);
  auto source = PictureSource::open(looking.rig());
  if (!source) return failed("camera: " + source.error().message);
  if (!options.snap && !options.watch) return check(options, *source);
  if (const auto* opened = source->opened(); opened && prevents(*opened)) check(options, *source);
  return options.snap ? snap(options, looking, *source) : watch(options, looking, *source);
}

void add_camera_options(CLI::App& command, CameraOptions& options) {
  command.add_flag("--list", options.list, "the cameras there are: genicam and gphoto2");
  command.add_option("--rig", options.rig,
                     "rig file: which camera, and how it is to be set; by itself: opens, checks and sets it");
  command
      .add_option("--snap", options.snap_file,
                  "take one picture, measure it, advise on its light; keep it in FILE")
      ->expected(0, 1)
      ->type_name("[FILE]");
  command.add_flag("--watch", options.watch, "one picture after the other, with the advice, until Ctrl-C");
  command.add_option("--advise", options.pictures, "advise on photographs that are there")->type_name("FILE");
  command.add_option(
      "--overlay", options.overlay,
      "write the picture with what was found drawn on it: a file's name, or of several a folder's");
  command.add_option("--exposure-ms", options.exposure_ms, "of pictures that are taken at once (default 10)")
      ->check(CLI::Range(0.001, 3.6e6));
  command.add_option("--photographs", options.photographs,
                     "folder whose next file is the picture, in place of the rig file's camera");
  command.add_option("--count", options.count, "so many pictures of --watch (default: until Ctrl-C)")
      ->check(CLI::Range(1, 1000000000));
  command
      .add_option("--effort", options.effort,
                  "how pictures are measured: fast, standard or thorough (default standard)")
      ->check(CLI::IsMember({"fast", "standard", "thorough"}));
  command.add_flag("--json", options.json, "one JSON object a line on standard output");
  command.add_flag("--plain", options.plain, "lines of text, no screen");
}

}  // namespace

void add_camera_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<CameraOptions>();
  CLI::App* command = app.add_subcommand("camera", "Check the camera, take a picture, advise on its light");
  add_camera_options(*command, *options);
  command_line::for_experts(*command, {"--count", "--effort", "--photographs"});
  command->footer(
      "Examples: strobe camera --list\n"
      "          strobe camera --rig rig.toml\n"
      "          strobe camera --rig rig.toml --snap focus.tif --overlay focus.png\n"
      "          strobe camera --rig rig.toml --watch\n"
      "          strobe camera --advise shots/*.tif\n"
      "Exit status: 1 if the camera is set so that photographs are spoiled, no picture came, or its light is "
      "wrong.");
  command->callback([options, command, &exit_status] {
    options->snap = command->count("--snap") > 0;
    exit_status = run_camera(*options);
  });
}

}  // namespace strobe::host
