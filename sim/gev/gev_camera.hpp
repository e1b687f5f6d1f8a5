// The rig's camera as a GigE Vision device on the loopback: it exposes while the rig's shutter line is active
// and sends the photographs to whoever controls it. A thread of its own, in rig time: answering takes none,
// sending as long as the link needs. Start and stop from one thread.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/result.hpp"
#include "sim/gev/device.hpp"
#include "sim/gev/pictures.hpp"
#include "sim/gev/stream_packets.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/live/exposures.hpp"
#include "sim/random/draws.hpp"

namespace strobe::sim::gev {

inline constexpr const char* kDefaultAddress = "127.0.0.1";

/// Its serial number: of its address, so that the rigs of a machine have different ones.
std::string serial_of(const std::string& address);
/// Empty: it is an IPv4 address of the loopback; else what is wrong, for a person.
std::string address_problem(const std::string& address);

class GevCamera {
 public:
  /// Fails if the address is none of the loopback or its port 3956 is taken, or if the scene's photographs
  /// are too large. `exposure_store` must outlive the camera.
  static Result<std::unique_ptr<GevCamera>> create(const std::string& address, const Scene& scene,
                                                   std::uint64_t seed, const ExposureStore& exposure_store,
                                                   RigClock clock = {});
  ~GevCamera();
  GevCamera(const GevCamera&) = delete;
  GevCamera& operator=(const GevCamera&) = delete;

  /// in_machines_time: the link is no faster than a receiver beside it keeps up with.
  void start(bool in_machines_time);
  void stop();

 private:
  /// A frame that packets may be asked for again of.
  struct Kept {
    StreamFrame frame;
    std::vector<std::uint32_t> gone;  ///< packets that never arrive
  };
  /// Packets of a frame that are to be sent.
  struct Sending {
    std::shared_ptr<const Kept> kept;
    std::uint32_t next = 0, end = 0;
    bool resent = false;
  };
  struct Waiting {
    std::shared_ptr<const Exposure> exposure;  ///< null: no exposure of the rig
    MonoTime begun, due;
  };

  GevCamera(const Scene& scene, std::uint64_t seed, const ExposureStore& exposure_store, RigClock clock);
  Result<void> open_sockets(const std::string& address);
  void run();
  Duration until_due() const;
  void take_datagrams();
  void obey();
  void look_for_exposures();
  void take_exposure(const std::shared_ptr<const Exposure>& exposure);
  bool exposes(const Exposure& exposure) const;
  void expose_by_itself();
  void adjust_by_itself();
  void make_frames();
  void make_frame(const Waiting& waiting);
  void queue_frame(Packet pixels, const Waiting& waiting);
  Result<Packet> pixels_of(const Waiting& waiting);
  void queue_resends();
  void queue_resend(const PacketRange& range);
  void send_some();
  bool is_lost(const Sending& sending, std::uint32_t id);
  void send_test_packet();
  void send(const Packet& packet);
  bool has(FaultKind kind, const Waiting& waiting) const;
  void vanish(Duration duration);
  void come_back();

  const Scene scene_;
  const std::uint64_t seed_;
  const ExposureStore& exposure_store_;
  const RigClock clock_;
  std::optional<Device> device_;
  std::vector<int> control_sockets_;  ///< its address, and those of broadcasts
  int stream_socket_ = -1;
  const int stop_event_;

  std::size_t seen_ = 0;  ///< exposures of the exposure_store
  std::vector<Waiting> waiting_;
  MonoTime next_own_ = kNoTime;  ///< a frame without a trigger
  std::uint16_t block_ = 0;      ///< the newest frame's
  std::deque<std::shared_ptr<const Kept>> kept_;
  std::deque<Sending> sending_;
  MonoTime send_at_;
  double rate_bps_;
  std::optional<MonoTime> away_until_;
  Draws draws_;  ///< of what the link loses
  std::optional<PictureSettings> room_settings_;
  Packet room_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace strobe::sim::gev
