// From the camera's folder to frames: photographs are matched to shots, measured on a thread of their own and
// kept. Stands between the messages and whoever follows them. Whatever is wrong with a photograph is said and
// stops nothing else. One thread's; reads and writes files.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "host/messages/message_decoder.hpp"
#include "host/photographs/camera_folder.hpp"
#include "host/photographs/photograph_matcher.hpp"
#include "host/photographs/photograph_reader.hpp"

namespace strobe::host {

struct PhotographSettings {
  double timeout_s = 5.0;             ///< of a photograph after its shot
  std::int64_t host_id = 0;           ///< written into the frames, not 0
  std::filesystem::path keep_folder;  ///< a session's; photographs/ in it keeps them; empty: none are kept
  double retry_timeout_s = 2.0;       ///< with a file that cannot be read
};

class PhotographPipeline : public MessageHandler {
 public:
  /// `next` gets every message. It must outlive the pipeline.
  PhotographPipeline(MessageHandler& next, std::unique_ptr<CameraFolder> folder, MeasurePhotograph measure,
                     PhotographSettings settings);

  void status(const strobe_msgs::status_t& message, std::int64_t now_ns) override;
  void event(const strobe_msgs::event_t& message, std::int64_t now_ns) override;
  void shot(const strobe_msgs::shot_t& message, std::int64_t now_ns) override;
  void frame(const strobe_msgs::frame_t& message, std::int64_t now_ns) override;

  /// Takes in what has arrived and what has been measured.
  void turn(std::int64_t now_ns);
  /// No shot will come any more: says what is left over.
  void end(std::int64_t now_ns);

  /// Measured photographs, to be handed to everybody, this pipeline included.
  std::vector<strobe_msgs::frame_t> take_frames() { return std::exchange(frames_, {}); }
  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }
  /// Readable when turn() has something to do at once.
  std::vector<int> descriptors() const { return {folder_->descriptor(), reader_.descriptor()}; }
  /// Photographs being read.
  std::size_t pending() const { return reader_.pending(); }

 private:
  void arrive(const Arrival& arrival);
  void follow(const PhotographDecision& decision);
  void finish(PhotographResult result);
  std::filesystem::path name_to_keep(const Arrival& arrival, const ShotKey& shot);
  void notify(std::string text) { notifications_.push_back(std::move(text)); }

  MessageHandler& next_;
  std::unique_ptr<CameraFolder> folder_;
  PhotographSettings settings_;
  PhotographMatcher match_;
  std::map<ShotKey, std::vector<double>> flash_times_s_;
  std::map<int, Arrival> held_;  ///< photographs not yet decided on, by number
  int next_photograph_ = 1;
  std::set<std::filesystem::path> under_way_;
  std::filesystem::path newest_;  ///< the photograph last matched
  std::set<std::filesystem::path> names_given_;
  std::vector<strobe_msgs::frame_t> frames_;
  std::vector<std::string> notifications_;
  PhotographReader reader_;
};

}  // namespace strobe::host
