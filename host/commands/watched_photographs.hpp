// The camera's photographs for commands that follow shots: where they arrive, and how they are measured. One
// thread's.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <strobe_msgs/frame_t.hpp>
#include <utility>
#include <vector>

#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "host/config/rig_file.hpp"
#include "host/photographs/photograph_pipeline.hpp"

namespace CLI {
class App;
}

namespace strobe::host {

struct PhotographOptions {
  std::string folder;               ///< empty: the rig file's camera.folder, if it names one
  std::string effort = "standard";  ///< as `strobe digitize` has it
};

/// --photographs and --effort.
void add_photograph_options(CLI::App& command, PhotographOptions& options);

class WatchedPhotographs {
 public:
  /// `session`: the folder that keeps photographs; empty: none does. `next` gets all messages.
  WatchedPhotographs(const RigFile& rig, PhotographOptions options, std::string session, std::int64_t host_id,
                     MessageHandler& next);

  /// Without a folder nothing is watched and all else does nothing. Fails with one line for a folder that
  /// cannot be watched, or if the rig file says nothing of the scale.
  Result<void> open();
  /// What is watched, and whether the camera's calibration is old.
  std::vector<std::string> opening_words() const;

  /// Who is to get the messages.
  MessageHandler& sink();
  bool own_frame(const std::string& channel, const void* data, std::size_t size) const;

  /// Frames measured since, and those of shots that came again: then somebody asked for them, from whom the
  /// frame was lost, too. The caller hands them to sink() and to everybody else.
  std::vector<strobe_msgs::frame_t> turn(std::int64_t now_ns);
  /// The same when no shot will come any more.
  std::vector<strobe_msgs::frame_t> end(std::int64_t now_ns);
  std::vector<std::string> take_notifications();
  std::vector<int> descriptors() const;

 private:
  /// Stands in the place of the desk, which comes later if at all.
  struct Relay : MessageHandler {
    Relay(MessageHandler& sink, WatchedPhotographs& photographs) : to(&sink), owner(photographs) {}
    void status(const strobe_msgs::status_t& m, std::int64_t now_ns) override { to->status(m, now_ns); }
    void event(const strobe_msgs::event_t& m, std::int64_t now_ns) override { to->event(m, now_ns); }
    void shot(const strobe_msgs::shot_t& m, std::int64_t now_ns) override {
      to->shot(m, now_ns);
      owner.send_again(m);
    }
    void frame(const strobe_msgs::frame_t& m, std::int64_t now_ns) override { to->frame(m, now_ns); }
    MessageHandler* to;
    WatchedPhotographs& owner;
  };

  void send_again(const strobe_msgs::shot_t& shot);
  std::vector<strobe_msgs::frame_t> measured();

  const RigFile& rig_;
  PhotographOptions options_;
  std::string session_;
  std::int64_t host_id_;
  MessageHandler& next_;
  Relay relay_;
  std::unique_ptr<PhotographPipeline> pipeline_;
  std::map<ShotKey, strobe_msgs::frame_t> measured_;
  std::vector<strobe_msgs::frame_t> again_;
};

}  // namespace strobe::host
