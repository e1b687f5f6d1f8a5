// A firmware, a tablet and a network that follow a script, on a clock of their own: every armed shot is fired,
// flashes, ends, and its frame comes. What the host is given and what it publishes is kept. One thread's.
#pragma once

#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/messages/channels.hpp"
#include "host/clock/clock_reading.hpp"
#include "host/messages/transport.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/sealed_sender.hpp"

namespace strobe::storage {

class ScriptedBench final : public host::Transport, public host::Clock {
 public:
  static constexpr std::int64_t kBoot = 77;
  using Message = std::pair<std::string, std::vector<std::uint8_t>>;

  explicit ScriptedBench(authentication::Key key, int shots_before = 0);

  // Ports. A turn takes 20 ms.
  bool receive(std::chrono::milliseconds, std::span<const int>, const Receiver& receiver) override;
  void publish(const std::string& channel, Bytes bytes) override;
  host::HostReading read() override { return {HostTime{now_}, WallTime{kWall + now_}, now_}; }

  Duration now() const { return now_; }
  /// All that a log should hold, in order.
  const std::vector<Message>& messages() const { return messages_; }
  /// When each FIRE came.
  const std::vector<Duration>& fires() const { return fires_; }
  bool armed() const { return status_.state == strobe_msgs::status_t::ARMED; }
  /// The shots whose summaries were sent.
  const std::vector<strobe_msgs::shot_t>& shots() const { return shots_; }

 private:
  static constexpr Duration kWall = std::chrono::hours{500'000};

  void obey(const strobe_msgs::command_t& command);
  void fire(std::int64_t host_id);
  void send_status();
  void send_event(std::int8_t kind, int shot_id, std::int64_t host_id = 0);
  void after(Duration delay, std::function<void()> action) {
    due_.emplace_back(now_ + delay, std::move(action));
  }
  template <typename Sent>
  void send(messages::Channel channel, const Sent& message);

  authentication::Key key_;
  testing::SealedSender lab_;
  host_test::SyntheticShot made_ = host_test::make_shot({});
  Duration now_ = std::chrono::seconds{100};
  Duration next_status_{};
  strobe_msgs::status_t status_{};
  std::int64_t first_of_shot_ = 0;
  std::vector<std::pair<Duration, std::function<void()>>> due_;
  std::vector<Message> arriving_, messages_;
  std::vector<Duration> fires_;
  std::vector<strobe_msgs::shot_t> shots_;
};

}  // namespace strobe::storage
