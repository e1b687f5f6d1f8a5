// A camera kept ready over its driver: opened, asked twice a second whether it answers, looked for when it is
// gone, its driver started anew when that ends or hangs. Single-threaded; never waits.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/units/time.hpp"
#include "host/tether/camera_driver.hpp"

namespace strobe::tether {

class TetheredCamera {
 public:
  struct Photograph {
    std::filesystem::path file;
    std::optional<ExposureStart> exposed;
  };

  /// `program`: of CameraDriver::find(). The folder of `open` must be there. Fails with one line if the
  /// driver cannot be started; whether the camera can be opened shows later.
  static Result<std::unique_ptr<TetheredCamera>> start(const std::filesystem::path& program, OpenRequest open,
                                                       HostTime now);

  void step(HostTime now);
  /// Whole, in the folder.
  std::vector<Photograph> take_photographs() { return std::exchange(photographs_, {}); }
  std::vector<LostEvent> take_lost() { return std::exchange(lost_, {}); }
  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }
  /// As it has been opened, and again when a setting or a problem is another one.
  std::vector<OpenedEvent> take_opened() { return std::exchange(news_, {}); }

  /// Why nothing may be fired, for a person: it is not open, does not answer, or is set so that photographs
  /// are spoiled. Empty: it is ready.
  std::string problem(HostTime now) const;
  /// As it was opened last; its settings. Absent: it has not been yet.
  const std::optional<OpenedEvent>& opened() const { return opened_; }
  /// Readable when step() has something to do at once; another one when the driver was started anew.
  int descriptor() const { return driver_->descriptor(); }

 private:
  TetheredCamera(std::filesystem::path program, OpenRequest open, std::unique_ptr<CameraDriver> driver,
                 HostTime now);
  void open(HostTime now);
  void ask(HostTime now);
  void restart(HostTime now);
  void on_gone(const std::string& why);
  void on(const CamerasEvent&, HostTime) {}
  void on(const OpenedEvent& event, HostTime now);
  void on(const ReadyEvent&, HostTime now);
  void on(const PhotographEvent& event, HostTime);
  void on(const LostEvent& event, HostTime) { lost_.push_back(event); }
  void on(const GoneEvent& event, HostTime) { on_gone(event.why); }
  void on(const FailedEvent& event, HostTime);
  void on(const NoteEvent& event, HostTime) { notifications_.push_back(event.text); }
  void tell_settings(const OpenedEvent& event);

  std::filesystem::path program_;
  OpenRequest request_;
  std::unique_ptr<CameraDriver> driver_;
  std::optional<OpenedEvent> opened_;
  std::string away_ = "the camera is being opened";  ///< empty: it is there
  HostTime started_;                                 ///< the driver, or the newest try to open
  HostTime asked_;                                   ///< the newest question
  HostTime answered_;                                ///< when that was asked which was answered last
  bool open_question_ = false;
  bool open_failed_ = false;
  std::int64_t most_resent_ = 0;  ///< packets of one photograph
  std::vector<OpenedEvent> news_;
  std::vector<Photograph> photographs_;
  std::vector<LostEvent> lost_;
  std::vector<std::string> notifications_;
};

}  // namespace strobe::tether
