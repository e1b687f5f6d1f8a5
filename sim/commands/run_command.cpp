#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <random>
#include <thread>

#include "common/authentication/key_file.hpp"
#include "common/config/files.hpp"
#include "common/messages/channels.hpp"
#include "sim/commands/commands.hpp"
#include "sim/flash_sequencer/flash_sequencer.hpp"
#include "sim/gev/gev_camera.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/live/child_process.hpp"
#include "sim/live/rig_runner.hpp"
#include "sim/live/tablet_operator.hpp"
#include "sim/live/tethered_camera.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/ptp/ptp_camera.hpp"
#include "sim/rig_file/rig_file.hpp"
#include "sim/scene/model.hpp"

namespace strobe::sim {

namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kWatchAfterDeath{100};
constexpr const char* kTerminal = "sequencer";  // in the chip's folder

Bias bias_of(ChipSettings::Bias bias) {
  switch (bias) {
    case ChipSettings::Bias::set:
      return Bias::set;
    case ChipSettings::Bias::ignored:
      return Bias::ignored;
    case ChipSettings::Bias::refused:
      return Bias::refused;
  }
  return Bias::set;
}

ChipSpec chip_of(const Scene& scene, bool with_sequencer) {
  ChipSpec spec;
  spec.name = scene.chip.name;
  spec.label = scene.chip.label;
  spec.on_release = scene.chip.keep_on_release ? OnRelease::keep : OnRelease::input;
  spec.bias = bias_of(scene.chip.bias);
  for (std::size_t i = 0; i < kLineNames.size(); ++i) {
    LineSpec line;
    line.name = std::string(kLineNames[i]);
    if (scene.chip.reset_pull != ChipSettings::Pull::none)
      line.reset_pull = scene.chip.reset_pull == ChipSettings::Pull::up ? 1 : 0;
    if (rig_line(static_cast<std::uint32_t>(i)) == RigLine::key) line.idle_level = scene.chip.key_level;
    if (rig_line(static_cast<std::uint32_t>(i)) == RigLine::estop) line.idle_level = scene.chip.estop_level;
    spec.lines.push_back(line);
  }
  for (const sequencer::ControlLine& control : sequencer::kControlLines) {
    if (!with_sequencer) break;
    spec.lines[control.line].name = std::string(control.name);
    spec.lines[control.line].idle_level = control.idle_level;
  }
  return spec;
}

const char* cause_name(Cause cause) {
  switch (cause) {
    case Cause::set:
      return "set";
    case Cause::request:
      return "request";
    case Cause::release:
      return "release";
    case Cause::drive:
      return "drive";
  }
  return "unknown";
}

Result<void> write_changes(const std::string& path, const std::vector<Change>& changes) {
  std::string text = "time_ns,line,name,level,cause\n";
  for (const Change& c : changes) {
    const std::string_view line = c.line < kLineNames.size() ? kLineNames[c.line] : std::string_view{};
    text += fmt::format("{},{},{},{},{}\n", to_ns(c.time), c.line, line, c.level, cause_name(c.cause));
  }
  return config::write_file(path, text);
}

std::uint64_t fresh_seed() {
  std::random_device device;
  return device() % 1'000'000;  // short enough to type again
}

/// The rig around a chip, from its start to the last line of its files.
class Session {
 public:
  static Result<std::unique_ptr<Session>> open(const RunOptions& options, const Scene& scene,
                                               const Model& model, std::uint64_t seed,
                                               const fs::path& folder) {
    std::unique_ptr<Session> session(new Session(options));
    auto chip = Chip::create(folder, chip_of(scene, options.sequencer));
    if (!chip) return tl::unexpected(chip.error());
    std::optional<gpio::TimeKeeper::Repeatable> repeatable;
    if (options.clock_start_s) repeatable = {*options.clock_start_s, seed + 1};
    chip->keep_time(options.pace, repeatable);
    const RigClock clock = chip->clock();
    auto truth = TruthFile::create(options.truth_file, scene);
    if (!truth) return tl::unexpected(truth.error());
    session->truth_ = std::move(*truth);
    if (!options.photographs.empty()) {
      auto tethered_camera =
          TetheredCamera::create(options.photographs, scene, seed, session->exposure_store_, clock);
      if (!tethered_camera) return tl::unexpected(tethered_camera.error());
      session->photographer_ = std::move(*tethered_camera);
      session->truth_->include_photographs(seed);
    }
    if (options.gev_camera) {
      auto camera =
          gev::GevCamera::create(options.camera_address, scene, seed, session->exposure_store_, clock);
      if (!camera) return tl::unexpected(camera.error());
      session->gev_camera_ = std::move(*camera);
      session->truth_->include_photographs(seed);
    }
    if (options.ptp_camera) {
      auto camera =
          ptp::PtpCamera::create(options.camera_address, scene, seed, session->exposure_store_, clock);
      if (!camera) return tl::unexpected(camera.error());
      session->ptp_camera_ = std::move(*camera);
      session->truth_->include_photographs(seed);
    }
    if (auto made = options.changes_file.empty() ? Result<void>() : write_changes(options.changes_file, {});
        !made)
      return tl::unexpected(made.error());
    session->runner_ = std::make_unique<RigRunner>(std::move(*chip), scene, seed, session->exposure_store_,
                                                   !options.changes_file.empty(), model);
    if (options.sequencer) {
      auto made = sequencer::FlashSequencer::create(folder / kTerminal, folder, seed, clock);
      if (!made) return tl::unexpected(made.error());
      session->sequencer_ = std::move(*made);
      session->runner_->tell_changes([&board = *session->sequencer_](const std::vector<Change>& changes) {
        board.lines_changed(changes);
      });
    }
    if (options.digitizer) {
      const auto key = authentication::find_key({options.key_file, ""});
      if (!key) return tl::unexpected(key.error());
      auto tablet_operator = TabletOperator::create(options.lcm_url, options.rig_name, key->key, scene, seed,
                                                    session->exposure_store_, *session->truth_, clock);
      if (!tablet_operator) return tl::unexpected(tablet_operator.error());
      session->tablet_operator_ = std::move(*tablet_operator);
      if (!options.photographs.empty() || options.gev_camera || options.ptp_camera)
        session->tablet_operator_->listen_only();
      session->tablet_operator_->start();
    }
    session->runner_->start();
    if (session->sequencer_) session->sequencer_->start();
    if (session->gev_camera_) session->gev_camera_->start(options.pace == gpio::Pace::machine);
    if (session->ptp_camera_) session->ptp_camera_->start(options.pace == gpio::Pace::machine);
    if (session->photographer_) session->photographer_->start(options.pace == gpio::Pace::machine);
    return session;
  }

  /// Called in the program under test: it lives in the rig's time.
  void take_along() const { runner_->take_along(); }

  /// Fails if not all could be written.
  Result<void> close() {
    std::this_thread::sleep_for(kWatchAfterDeath);
    runner_->stop();
    sequencer_.reset();
    if (tablet_operator_) tablet_operator_->stop();
    for (const auto& exposure : exposure_store_.all()) truth_->write(*exposure, 0);
    if (gev_camera_) gev_camera_->stop();
    const auto photographs = photographer_ ? photographer_->stop() : Result<void>{};
    const auto card = ptp_camera_ ? ptp_camera_->stop() : Result<void>{};
    const auto changes = options_.changes_file.empty()
                             ? Result<void>{}
                             : write_changes(options_.changes_file, runner_->changes());
    const auto truth = truth_->close();
    return !photographs ? photographs : !card ? card : !changes ? changes : truth;
  }

 private:
  explicit Session(const RunOptions& options) : options_(options) {}

  const RunOptions& options_;
  ExposureStore exposure_store_;
  std::unique_ptr<TruthFile> truth_;
  std::unique_ptr<sequencer::FlashSequencer> sequencer_;  ///< the runner tells it of changes
  std::unique_ptr<RigRunner> runner_;
  std::unique_ptr<TabletOperator> tablet_operator_;
  std::unique_ptr<TetheredCamera> photographer_;
  std::unique_ptr<gev::GevCamera> gev_camera_;
  std::unique_ptr<ptp::PtpCamera> ptp_camera_;
};

/// The firmware's train is not known in advance: the model is chosen for the usual one.
constexpr ShootSettings kUsualTrain{.period = milliseconds(3), .exposure = milliseconds(500)};

Result<void> write_rig_of(const RunOptions& options, const Scene& scene) {
  if (options.rig_file.empty()) return {};
  const std::string url = options.lcm_url == messages::kDefaultLcmUrl ? "" : options.lcm_url;
  RigFileSettings settings;
  settings.rig_name = options.rig_name;
  settings.lcm_url = url;
  settings.key_file = options.key_file;
  settings.photographs = options.photographs;
  if (options.sequencer) settings.sequencer = fs::absolute(options.chip_dir) / kTerminal;
  if (options.gev_camera) {
    settings.camera_kind = "genicam";
    settings.camera_address = options.camera_address;
    settings.camera_serial = gev::serial_of(options.camera_address);
  }
  if (options.ptp_camera) {
    settings.camera_kind = "gphoto2";
    settings.camera_address = "ptpip:" + options.camera_address;
    settings.camera_serial = ptp::serial_of(options.camera_address);
  }
  return write_rig_file(options.rig_file, scene, settings);
}

}  // namespace

int run_command(const RunOptions& options) {
  if (!messages::valid_rig_name(options.rig_name))
    return report_error("--rig: 1 to 24 letters, digits, _ or -, not \"" + options.rig_name + "\"", 2);
  if (options.sequencer && options.chip_dir.empty())
    return report_error("--sequencer: its terminal is in the chip's folder, give one by --chip-dir", 2);
  const auto scene = load_scene(options.scene);
  if (!scene) return report_error(scene.error().message, 2);
  if (const auto written = write_rig_of(options, *scene); !written)
    return report_error(written.error().message, 2);
  if (options.command.empty()) {
    return options.rig_file.empty()
               ? report_error("run: the command to run is missing: strobe-sim run ... -- COMMAND", 2)
               : 0;
  }
  Model model = Model::full();
  if (const int status = choose_model(options.tolerance, *scene, kUsualTrain, model); status != 0)
    return status;
  model = model.with(Effect::shutter_lag);  // which the firmware's rig file has
  const std::uint64_t seed = options.seed.value_or(fresh_seed());
  block_child_signals();
  std::optional<TemporaryFolder> temporary;
  if (options.chip_dir.empty()) temporary.emplace();
  const fs::path folder = temporary ? temporary->path() : fs::absolute(options.chip_dir);
  if (folder.empty()) return report_error("no folder for the chip can be made", 1);
  auto session = Session::open(options, reduced_scene(*scene, model), model, seed, folder);
  if (!session) return report_error(session.error().message, 2);
  fmt::print(stderr, "strobe-sim: scene {}, seed {} (repeat with --seed {}), chip /dev/{} in {}\n",
             scene->name, seed, seed, scene->chip.name, folder.string());

  const auto child = start_joined(options.command, folder, [&session] { (*session)->take_along(); });
  if (!child) return report_error(child.error().message, 2);
  const int status = wait_for_child(*child);
  if (const auto closed = (*session)->close(); !closed) return report_error(closed.error().message, 1);
  return status;
}

}  // namespace strobe::sim
