#include "host/commands/watched_photographs.hpp"

#include <CLI/CLI.hpp>

#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"
#include "host/commands/terminal.hpp"
#include "host/photographs/measure_photograph.hpp"

namespace strobe::host {
namespace {

std::string folder_of(const PhotographOptions& options, const RigFile& rig) {
  return options.folder.empty() ? rig.camera.folder.value_or("") : options.folder;
}

}  // namespace

void add_photograph_options(CLI::App& command, PhotographOptions& options) {
  command.add_option("--photographs", options.folder,
                     "folder where the camera's photographs arrive (default: the rig file's camera.folder)");
  command
      .add_option("--effort", options.effort,
                  "how photographs are digitized: fast, standard or thorough (default standard)")
      ->check(CLI::IsMember({"fast", "standard", "thorough"}));
}

WatchedPhotographs::WatchedPhotographs(const RigFile& rig, PhotographOptions options, std::string session,
                                       std::int64_t host_id, MessageHandler& next)
    : rig_(rig),
      options_(std::move(options)),
      session_(std::move(session)),
      host_id_(host_id),
      next_(next),
      relay_(next, *this) {}

Result<void> WatchedPhotographs::open() {
  const std::string folder = folder_of(options_, rig_);
  if (folder.empty()) return {};
  if (!rig_.camera.px_per_m && !rig_.analysis.px_per_m) {
    return fail(
        "photographs need a scale: camera.px_per_m (strobe calibrate) or analysis.px_per_m in the rig file");
  }
  auto watched = CameraFolder::open(folder, steady_now_ns());
  if (!watched) return tl::unexpected(watched.error());
  PhotographSettings settings;
  settings.timeout_s = rig_.analysis.photograph_timeout_s;
  settings.host_id = host_id_;
  settings.keep_folder = session_;
  pipeline_ = std::make_unique<PhotographPipeline>(
      next_, std::move(*watched),
      photograph_measurer(rig_, digitize::effort_from_name(options_.effort).value()), settings);
  relay_.to = pipeline_.get();
  return {};
}

std::vector<std::string> WatchedPhotographs::opening_words() const {
  std::vector<std::string> words;
  if (!pipeline_) return words;
  words.push_back("photographs from " + folder_of(options_, rig_));
  if (auto warning = calibration_warning(rig_.camera, wall_now_us() / 1'000'000)) words.push_back(*warning);
  return words;
}

MessageHandler& WatchedPhotographs::sink() { return relay_; }

bool WatchedPhotographs::own_frame(const std::string& channel, const void* data, std::size_t size) const {
  if (!pipeline_ || channel != messages::channel_name(rig_.rig, messages::Channel::frame)) return false;
  strobe_msgs::frame_t frame;
  return messages::decode_checked(frame, data, size) &&
         frame.host_id == host_id_;
}

std::vector<strobe_msgs::frame_t> WatchedPhotographs::turn(std::int64_t now_ns) {
  if (!pipeline_) return {};
  pipeline_->turn(now_ns);
  return measured();
}

std::vector<strobe_msgs::frame_t> WatchedPhotographs::end(std::int64_t now_ns) {
  if (!pipeline_) return {};
  pipeline_->end(now_ns);
  return measured();
}

std::vector<strobe_msgs::frame_t> WatchedPhotographs::measured() {
  std::vector<strobe_msgs::frame_t> frames = std::exchange(again_, {});
  for (strobe_msgs::frame_t& frame : pipeline_->take_frames()) {
    measured_.insert_or_assign({frame.boot_id, frame.shot_id}, frame);
    frames.push_back(std::move(frame));
  }
  return frames;
}

void WatchedPhotographs::send_again(const strobe_msgs::shot_t& shot) {
  const auto frame = measured_.find({shot.boot_id, shot.shot_id});
  if (frame != measured_.end()) again_.push_back(frame->second);
}

std::vector<std::string> WatchedPhotographs::take_notifications() {
  return pipeline_ ? pipeline_->take_notifications() : std::vector<std::string>();
}

std::vector<int> WatchedPhotographs::descriptors() const {
  return pipeline_ ? pipeline_->descriptors() : std::vector<int>();
}

}  // namespace strobe::host
