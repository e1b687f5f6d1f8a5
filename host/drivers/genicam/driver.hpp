// The conversation with strobe: finds the camera that is asked for, keeps it open, and looks for it again
// when it is gone. One thread's.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "host/drivers/genicam/presence.hpp"
#include "host/drivers/genicam/session.hpp"
#include "host/tether/driver_channel.hpp"
#include "host/tether/driver_messages.hpp"

namespace strobe::genicam {

class Driver {
 public:
  explicit Driver(tether::DriverChannel& channel) : channel_(channel) {}
  /// Until nobody listens any more.
  void run();

 private:
  /// A camera that was open and is gone.
  struct Away {
    tether::CameraIdentity camera;
    HostTime since, next_try, next_list;
    std::unique_ptr<PresenceWatch> presence;  ///< at its address
    std::string told;                         ///< why it could not be opened last
  };

  void handle(const tether::ListRequest&);
  void handle(const tether::OpenRequest& request);
  void handle(const tether::SnapRequest& request);
  void handle(const tether::CheckRequest&);
  void work();
  void lose();
  void look_for_it(HostTime now);
  std::optional<std::string> found_again(HostTime now);
  Duration list_every() const;
  void wait() const;
  void send(const tether::Event& event) { channel_.send(event); }

  tether::DriverChannel& channel_;
  tether::OpenRequest request_;
  std::unique_ptr<Session> session_;
  std::optional<Away> away_;
};

}  // namespace strobe::genicam
