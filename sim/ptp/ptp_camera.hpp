// The rig's camera as one that speaks PTP/IP (ISO 15740, CIPA DC-005), as a DSLR on a network does: it
// exposes while the SHUTTER line is active, renders the photograph, keeps it as a file on its memory card and
// tells the host, which takes it over. Two threads of its own: one renders, one answers. Start and stop from
// one thread.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "common/result.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/live/exposures.hpp"
#include "sim/ptp/responder.hpp"
#include "sim/ptp/server.hpp"

namespace strobe::sim::ptp {

/// Its serial number: of its address, so that the rigs of a machine have different ones.
std::string serial_of(const std::string& address);

class PtpCamera {
 public:
  /// `address`: an IPv4 address of this machine. Fails if it cannot be had, or no folder for the card's files
  /// (in the folder for temporary files; removed in the end). `exposure_store` must outlive the camera.
  static Result<std::unique_ptr<PtpCamera>> create(const std::string& address, const Scene& scene,
                                                   std::uint64_t seed, const ExposureStore& exposure_store,
                                                   RigClock clock = {});
  ~PtpCamera();
  PtpCamera(const PtpCamera&) = delete;
  PtpCamera& operator=(const PtpCamera&) = delete;

  /// gives_way: rendering uses only the time that the rig and the program under test leave.
  void start(bool gives_way);
  /// Ends the threads. The first file that could not be written.
  Result<void> stop();

 private:
  PtpCamera(const std::string& serial, const std::filesystem::path& folder, const Scene& scene,
            std::uint64_t seed, const ExposureStore& exposure_store, RigClock clock);
  void render_exposures(bool gives_way);
  void take_exposures();
  void take_picture();  ///< that the host has asked for
  MonoTime due(const Exposure& exposure);
  void photograph(const Exposure& exposure);
  Result<void> write_files(const Exposure& exposure, FilesWritten wanted, const std::filesystem::path& stem);
  bool has(FaultKind kind, const Exposure& exposure) const {
    return shot_fault(scene_.faults, kind, exposure.shot) != nullptr;
  }
  void meet_faults(const Exposure& exposure);

  void serve();
  Result<void> go_or_come_back();
  void send_events();
  Answer answer(const OperationRequest& request);

  const std::filesystem::path folder_;  ///< of the card's files
  const Scene scene_;
  const std::uint64_t seed_;
  const ExposureStore& exposure_store_;
  const RigClock clock_;
  std::vector<std::shared_ptr<const Exposure>> waiting_;
  std::size_t seen_ = 0;  ///< exposures of the exposure_store
  std::unique_ptr<Server> server_;
  std::atomic<bool> stopping_{false};
  std::thread renders_, serves_;

  std::mutex mutex_;  ///< of all that follows
  Properties properties_;
  Card card_;
  Responder responder_;
  std::vector<Event> events_;      ///< not sent yet
  MonoTime away_until_ = kNoTime;  ///< its network is cut
  Result<void> outcome_;
};

}  // namespace strobe::sim::ptp
