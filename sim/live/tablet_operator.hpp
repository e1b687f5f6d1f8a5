// The simulated operator of the digitizing tablet, on LCM: when a shot is announced (SHOT), finds the
// exposure of that time in the store, digitizes it and sends the frame (FRAME). A shot announced again is
// sent again. One of the lab: he believes no announcement without its seal, and seals his frames. A thread of
// its own; start and stop from one thread.
#pragma once

#include <atomic>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "common/authentication/packet_seal.hpp"
#include "common/shot/shot_key.hpp"
#include "common/wire/assembler.hpp"
#include "common/wire/channel_socket.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/live/exposures.hpp"
#include "sim/rig/tablet.hpp"

namespace strobe::sim {

/// The message for a digitized photograph of that shot.
strobe_msgs::frame_t to_message(const reduction::Frame& frame, std::int64_t boot_id, int shot_id);

class TabletOperator {
 public:
  /// Fails if LCM cannot be joined (wire/lcm_url.hpp). `exposure_store` and `truth` must outlive it.
  static Result<std::unique_ptr<TabletOperator>> create(const std::string& lcm_url,
                                                        const std::string& rig_name,
                                                        const authentication::Key& key, const Scene& scene,
                                                        std::uint64_t seed, ExposureStore& exposure_store,
                                                        TruthFile& truth, RigClock clock = {});
  ~TabletOperator();
  TabletOperator(const TabletOperator&) = delete;
  TabletOperator& operator=(const TabletOperator&) = delete;

  /// Digitizes nothing: shots' numbers are read for the truth file, no frame is sent. Before start().
  void listen_only() { sends_ = false; }

  void start();
  /// Ends the thread; shots announced but not yet processed are written to the truth file.
  void stop();

 private:
  struct Task {
    ShotKey key;
    MonoTime shot_start;
    MonoTime announced;
    std::shared_ptr<const Exposure> exposure;
    MonoTime due = kNoTime;  ///< to send; known once the exposure is
  };

  TabletOperator(const Scene& scene, std::uint64_t seed, ExposureStore& exposure_store, TruthFile& truth,
                 std::string rig_name, const authentication::Key& key, RigClock clock);
  Result<void> join(const std::string& lcm_url);
  void run();
  Duration until_due() const;
  /// Takes in what has arrived, after waiting for it until something is due.
  void receive();
  void on_shot(const strobe_msgs::shot_t& shot);
  void publish(const strobe_msgs::frame_t& frame);
  /// True if the task is finished.
  bool process(Task& task, MonoTime now);
  bool find_exposure(Task& task, MonoTime now);
  void send(const Task& task);

  const Scene scene_;
  std::uint64_t seed_;
  ExposureStore& exposure_store_;
  TruthFile& truth_;
  const RigClock clock_;
  std::string rig_name_;
  authentication::PacketSeal seal_;
  authentication::PacketNumber packet_;  ///< the newest sent
  bool sends_ = true;
  std::unique_ptr<lcm::LCM> lcm_;  ///< sends only
  std::optional<wire::ChannelSocket> socket_;
  wire::Assembler assembler_;
  std::vector<Task> tasks_;
  std::set<ShotKey> announced_;
  std::map<ShotKey, strobe_msgs::frame_t> sent_;
  std::atomic<bool> stopping_{false};
  const int stop_event_;  ///< an eventfd that ends a wait
  std::thread thread_;
};

}  // namespace strobe::sim
