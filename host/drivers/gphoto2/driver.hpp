// The driver of cameras that libgphoto2 knows: requests from strobe, events of the camera. The rig's line
// holds the shutter open; here only what the camera then tells is listened to. One that is gone is looked for
// each second. Single-threaded.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "host/drivers/gphoto2/new_photographs.hpp"
#include "host/tether/driver_channel.hpp"

namespace strobe::gphoto2 {

class Driver {
 public:
  /// Descriptors for requests and events.
  Driver(int input, int output) : channel_(input, output) {}
  /// Until nobody listens any more.
  void run();

 private:
  void handle(const tether::ListRequest&);
  void handle(const tether::OpenRequest& request);
  void handle(const tether::SnapRequest& request);
  void handle(const tether::CheckRequest&);

  Result<void> open();
  void look_again(HostTime now);
  void step(HostTime now);
  void take_events(HostTime now);
  /// Asks for settings and problems anew, and tells them if they are not what was told last.
  void tell_state(HostTime now, bool in_any_case);
  void take_photographs(HostTime now);
  void on_gone(const std::string& why);

  tether::DriverChannel channel_;
  std::optional<tether::OpenRequest> wanted_;
  std::unique_ptr<GphotoCamera> camera_;       ///< null: not open, or gone
  std::optional<NewPhotographs> photographs_;  ///< since it was opened first
  std::string serial_;                         ///< of the one that was opened first
  std::map<std::string, std::string> asked_, refused_;
  std::string told_;  ///< the newest OpenedEvent
  bool tells_events_ = true, was_away_ = false, changed_ = false;
  std::string why_gone_ = "it is not open";
  HostTime tried_{}, read_{}, looked_{}, newest_file_{};
  std::optional<HostTime> exposed_;  ///< an exposure of which there is no file yet
};

}  // namespace strobe::gphoto2
