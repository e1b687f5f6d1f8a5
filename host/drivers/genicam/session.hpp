// A camera that is open: armed, its frames written as photographs, its clock related to this machine's, its
// settings watched. One thread's; blocks while it talks to the camera.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "host/clock/camera_clock.hpp"
#include "host/drivers/genicam/camera.hpp"
#include "host/drivers/genicam/frame_count.hpp"
#include "host/drivers/genicam/presence.hpp"
#include "host/drivers/genicam/settings.hpp"
#include "host/drivers/genicam/stamp_latch.hpp"
#include "host/drivers/genicam/stream.hpp"
#include "host/tether/driver_messages.hpp"

namespace strobe::genicam {

using Tell = std::function<void(const tether::Event&)>;

class Session {
 public:
  /// address: as Camera::open().
  static Result<std::unique_ptr<Session>> open(const tether::OpenRequest& request,
                                               const std::string& address);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  tether::OpenedEvent opened() const;
  const tether::CameraIdentity& identity() const { return camera_->identity(); }
  std::vector<int> descriptors() const;
  HostTime next_due() const;

  /// Frames that have come, then what is due. Tells what is to be told.
  void work(HostTime now, const Tell& tell);
  /// Why the camera is taken for gone; empty: it is not. Its farewell may take seconds then.
  const std::string& gone() const { return gone_; }

  /// ReadyEvent once the camera has answered, by work() at the latest.
  void check(HostTime now, const Tell& tell);
  /// One photograph at once; it comes, or a FailedEvent, by work() at the latest.
  void snap(double exposure_s, HostTime now, const Tell& tell);

 private:
  Session() = default;
  Result<void> arm();
  Result<void> start();
  void stop();
  void take_frame(const Received& received, const Tell& tell);
  void tell_missing(const Counted& counted, const Tell& tell);
  std::optional<tether::ExposureStart> exposed(const Received& received) const;
  void keep_house(HostTime now, const Tell& tell);
  void relate_clock();
  void change(const std::string& name, const std::string& value);
  void end_snap(const Tell& tell);

  tether::OpenRequest request_;
  std::unique_ptr<Camera> camera_;
  std::optional<Settings> settings_;
  std::unique_ptr<Stream> stream_;
  std::optional<StampLatch> latch_;
  host::CameraClock clock_;
  int clock_restarts_ = 0;
  int unlatched_ = 0;  ///< in a row
  std::unique_ptr<PresenceWatch> presence_;
  bool checking_ = false;
  FrameCount count_{1};
  HostTime next_latch_, next_house_;
  std::size_t looked_at_ = 0;
  bool changed_ = false;
  std::optional<HostTime> snap_until_;
  std::vector<std::pair<std::string, std::string>> before_snap_;
  std::string gone_;
};

}  // namespace strobe::genicam
