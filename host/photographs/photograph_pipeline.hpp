// From the camera's folder to frames: photographs are matched to shots, measured on a thread of their own,
// and a copy of each is kept. What goes wrong with one photograph is told and stops nothing else.
// Single-threaded but for the reader's thread; reads and writes files.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "common/result.hpp"
#include "common/shot/recent_map.hpp"
#include "host/config/rig_file.hpp"
#include "host/photographs/camera_folder.hpp"
#include "host/photographs/left_photographs.hpp"
#include "host/photographs/photograph_matcher.hpp"
#include "host/photographs/photograph_reader.hpp"
#include "host/tether/tethered_camera.hpp"

namespace strobe::host {

struct PhotographSettings {
  double timeout_s = 5.0;             ///< of a photograph after its shot
  std::int64_t host_id = 0;           ///< written into the frames, not 0
  std::filesystem::path keep_folder;  ///< the session's; its photographs/ keeps the copies; empty: no copies
  double retry_timeout_s = 2.0;       ///< how long a file that cannot be read is tried again
};

/// A photograph that has been read, where the session keeps it (or where it lies, if no copies are kept).
struct KeptPhotograph {
  ShotKey shot;
  std::filesystem::path file;
};

class PhotographPipeline {
 public:
  /// `clock` relates the firmware's clock to the host's; it must outlive the pipeline.
  PhotographPipeline(const DeviceClock& clock, std::unique_ptr<CameraFolder> folder,
                     MeasurePhotograph measure, PhotographSettings settings);

  /// Photographs come from this camera, which puts them into the folder; one that is of no shot is put into
  /// the folder's unused/.
  void set_camera(std::unique_ptr<tether::TetheredCamera> camera) { camera_ = std::move(camera); }
  /// Why nothing may be fired: the camera is away, or spoils its photographs. Empty: it is ready, or files
  /// just come.
  std::string camera_problem(HostTime now) const { return camera_ ? camera_->problem(now) : ""; }

  /// A photograph tells when it was exposed, so that none is taken for another shot's, however late it comes.
  bool stamped() const { return camera_ && camera_->opened() && camera_->opened()->has_clock; }

  /// A shot's summary. When it comes again, somebody has asked for it who may have lost its frame, too: the
  /// frame is then handed out again.
  void on_shot(const strobe_msgs::shot_t& shot);
  /// A frame that anybody has measured, this pipeline included.
  void on_frame(const strobe_msgs::frame_t& frame);

  /// Measures what earlier runs left of the camera's photographs and fits a shot that is wanted
  /// (left_photographs.hpp). Returns the shots.
  std::vector<ShotKey> measure_left(const LeftShots& shots, const DeviceClock& clock);
  /// Of these, so many are not measured yet.
  int left() const { return left_; }

  /// Takes in what has arrived and what has been measured.
  void step(HostTime now);
  /// No shot will come any more: tells what is left over.
  void end(HostTime now);

  /// Frames to be published and taken in.
  std::vector<strobe_msgs::frame_t> take_frames() { return std::exchange(frames_, {}); }
  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }
  /// Also those of dry shots, which nobody measures.
  std::vector<KeptPhotograph> take_kept() { return std::exchange(kept_, {}); }
  /// The camera as it has been opened, its settings as read back; again when they have changed.
  std::vector<tether::OpenedEvent> take_camera_states() {
    return camera_ ? camera_->take_opened() : std::vector<tether::OpenedEvent>{};
  }
  /// Photographs that could not be kept, in words.
  std::vector<std::string> take_not_kept() { return std::exchange(not_kept_, {}); }
  void notify(std::string text) { notifications_.push_back(std::move(text)); }
  /// Readable when step() has something to do at once.
  std::vector<int> descriptors() const {
    return {camera_ ? camera_->descriptor() : folder_->descriptor(), reader_.descriptor()};
  }
  /// Photographs being read.
  std::size_t pending() const { return reader_.pending(); }

 private:
  static constexpr std::size_t kMaxShots = 200;
  static constexpr std::size_t kMaxMeasured = 1000;

  std::vector<Arrival> look(HostTime now);
  void add(const Arrival& arrival);
  void tell_lost(const Arrival& arrival, const PhotographDecision& decision);
  void put_aside(const std::filesystem::path& file);
  void tell_light(const PhotographLight& light);
  void apply(const PhotographDecision& decision);
  void finish(PhotographResult result);
  std::filesystem::path name_to_keep(const std::filesystem::path& file, const ShotKey& shot);
  std::string name_in_session(const PhotographJob& job, bool kept) const;

  std::unique_ptr<CameraFolder> folder_;
  std::unique_ptr<tether::TetheredCamera> camera_;  ///< null: files just come
  PhotographSettings settings_;
  PhotographMatcher matcher_;
  RecentMap<ShotKey, std::vector<double>> flash_times_s_{kMaxShots};
  std::map<int, Arrival> undecided_;  ///< photographs not yet decided on, by number
  int next_photograph_ = 1;
  int left_ = 0;
  std::set<std::filesystem::path> being_read_;
  std::filesystem::path newest_;  ///< the photograph last matched
  std::set<std::filesystem::path> names_used_;
  RecentMap<ShotKey, strobe_msgs::frame_t> measured_{kMaxMeasured};
  std::vector<strobe_msgs::frame_t> frames_;
  std::vector<KeptPhotograph> kept_;
  std::vector<std::string> notifications_, not_kept_;
  std::set<std::string> told_of_light_;  ///< what was not well, each told once
  PhotographReader reader_;
};

// The photograph pipeline as rig file and command line want it. Reads files; allocates.

struct PhotographOptions {
  std::string folder;               ///< empty: what the rig file's [camera] says
  std::string effort = "standard";  ///< as `strobe digitize` has it
  double exposure_s = 0.5;          ///< of a shot, for a camera that keeps its own time
};

/// What the rig file's camera is opened with; it puts its photographs into `folder`.
tether::OpenRequest open_request(const CameraConnection& connection, const std::filesystem::path& folder,
                                 double exposure_s);

/// Returns null if neither folder nor camera is named. Fails with one line if the folder cannot be watched,
/// the camera's driver is not installed, or the rig file gives no scale. The pipeline's first notifications
/// name the folder, and tell if the calibration is old. A camera puts its photographs into keep_folder's
/// incoming/; who keeps none speaks to no camera. keep_folder: the session's; empty: no photograph is copied.
Result<std::unique_ptr<PhotographPipeline>> open_pipeline(const RigFile& rig,
                                                          const PhotographOptions& options,
                                                          const std::filesystem::path& keep_folder,
                                                          std::int64_t host_id, const DeviceClock& clock,
                                                          const HostReading& now);

}  // namespace strobe::host
