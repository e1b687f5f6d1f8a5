// A host that speaks to strobed in single messages, for what no command of strobe does on purpose: commands
// that are stale, repeated, late or meant for another boot. One thread; messages are taken in whenever it
// waits.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>
#include <thread>
#include <vector>

#include "common/authentication/key.hpp"
#include "sim/gpiochip/chip.hpp"
#include "tests/hil/line_changes.hpp"
#include "tests/hil/rig_fixture.hpp"

namespace strobe::hil {

class RawHost {
 public:
  /// `bench` must outlive it.
  explicit RawHost(const RigFixture& bench);

  /// Takes messages in until the condition holds or the limit passed; tells whether it holds.
  bool wait(const std::function<bool()>& condition, std::chrono::milliseconds limit);
  void listen(std::chrono::milliseconds time);

  bool wait_status();  ///< the first one of strobed
  /// A person resets what has stopped the rig, and waits until it may be armed again. Returns whether it may.
  bool reset();
  /// Asks for a new token, as a person who has a stop reset first; 0: none was given.
  std::int64_t arm(std::chrono::milliseconds limit = std::chrono::seconds(10));
  using ShotOfToken = std::function<strobe_msgs::command_t(std::int64_t token)>;
  /// Arms and fires until a first flash is seen; the instant of that flash, or 0 after so many shots that came late,
  /// as in the machine's own time. std::runtime_error if none can be fired.
  std::int64_t fire_until_flash(LineWatcher& watch, const ShotOfToken& shot, int shots = 1);
  /// A dry or live shot of the rig file's kind: 3 ms, 200 ms exposure.
  strobe_msgs::command_t fire_command(std::int64_t token, bool dry);
  strobe_msgs::command_t command(std::int8_t kind);  ///< addressed to the boot last seen, with the next id
  void send(const strobe_msgs::command_t& command);  ///< under seal
  /// Bytes as they are, on the command channel.
  void send_bytes(std::span<const std::uint8_t> bytes);
  /// As send() puts it on the channel; key: the lab's, or a stranger's.
  std::vector<std::uint8_t> sealed(const strobe_msgs::command_t& command,
                                   const authentication::Key& key) const;
  static std::vector<std::uint8_t> body(const strobe_msgs::command_t& command);
  const authentication::Key& key() const { return key_; }

  const strobe_msgs::status_t& status() const { return status_; }
  const std::vector<strobe_msgs::event_t>& events() const { return events_; }
  const std::vector<strobe_msgs::shot_t>& shots() const { return shots_; }
  bool saw(std::int8_t event_kind) const;

 private:
  void take_status(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::status_t* status);
  void take_event(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::event_t* event);
  void take_shot(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::shot_t* shot);

  /// Of strobed's clock, by which commands are stamped.
  std::int64_t boot_time_ns();

  const RigFixture& bench_;
  std::optional<sim::Chip> chip_;
  lcm::LCM lcm_;
  std::string rig_;
  authentication::Key key_;  ///< where strobe looks for it
  std::int64_t host_id_;
  std::int64_t next_command_ = 1;
  bool status_seen_ = false;
  strobe_msgs::status_t status_{};
  std::vector<strobe_msgs::event_t> events_;
  std::vector<strobe_msgs::shot_t> shots_;
};

/// A log as lcm-logger and strobed write it.
struct LogContents {
  std::vector<strobe_msgs::event_t> events;
  std::vector<strobe_msgs::shot_t> shots;
  std::vector<strobe_msgs::frame_t> frames;
  int commands = 0;
  int other = 0;
};
LogContents read_log(const std::string& path);

// A stranger on the bus who sends as fast as the machine can: packets that look like commands, sealed with
// another key; replays of true ones; bytes without sense; datagrams of the largest size. A thread of its own.

using Bytes = std::vector<std::uint8_t>;

/// A socket that sends datagrams to an LCM URL's group, on this machine only. std::runtime_error if there is
/// none.
class RawSender {
 public:
  explicit RawSender(const std::string& lcm_url);
  ~RawSender();
  RawSender(const RawSender&) = delete;
  RawSender& operator=(const RawSender&) = delete;

  bool send(const Bytes& datagram) const;  ///< false: the kernel has no room
  /// As LCM would send it, in one datagram.
  static Bytes whole(std::string_view channel, const Bytes& message);

 private:
  int fd_ = -1;
};

class Flooder {
 public:
  enum Kind { forged, replayed, garbage, oversized };
  static constexpr std::size_t kKinds = 4;

  /// true_command: sealed bytes that the firmware has executed before.
  Flooder(const std::string& lcm_url, const std::string& rig, const Bytes& true_command);
  ~Flooder() { stop(); }

  std::int64_t stop();  ///< packets sent
  std::int64_t sent() const { return sent_; }

 private:
  void run(const std::stop_token& stop);

  RawSender sender_;
  std::array<Bytes, kKinds> datagrams_;
  std::atomic<std::int64_t> sent_{0};
  std::jthread thread_;
};

}  // namespace strobe::hil
