// A firmware, a tablet and a network that follow a script, on a clock of their own: every armed shot is fired,
// flashes, ends, and its frame comes. What the host is given and what it publishes is kept. One thread's.
#pragma once

#include <functional>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include "common/authentication/seal.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/host_bench.hpp"
#include "tests/support/sealed_sender.hpp"

namespace strobe::storage {

using messages::Channel;
using strobe_msgs::command_t;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

class ScriptedBench final : public host::Transport, public host::Clock {
 public:
  static constexpr std::int64_t kBoot = 77;
  using Message = testing::RememberingBus::Packet;

  explicit ScriptedBench(authentication::Key key, int shots_before = 0) : key_(std::move(key)), lab_(key_) {
    status_.schema_version = status_t::SCHEMA_VERSION;
    status_.boot_id = kBoot + shots_before;
    status_.key_active = status_.journal_ok = status_.real_time = true;
    status_.last_shot_id = shots_before;
  }

  // Ports. A turn takes 20 ms.
  bool receive(std::chrono::milliseconds, std::span<const int>, const Receiver& receiver) override {
    now_ += milliseconds{20};
    for (std::size_t i = 0; i < due_.size();) {
      if (due_[i].first > now_) {
        ++i;
        continue;
      }
      const auto action = std::move(due_[i].second);
      due_.erase(due_.begin() + static_cast<std::ptrdiff_t>(i));
      action();
    }
    if (now_ >= next_status_) send_status();
    for (const Message& message : std::exchange(arriving_, {})) {
      messages_.push_back(message);
      receiver(message.first, message.second);
    }
    return true;
  }
  void publish(const std::string& channel, Bytes bytes) override {
    messages_.emplace_back(channel, std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
    if (channel != messages::channel_name("bench", Channel::command)) return;
    const auto body = authentication::unseal(key_, "bench", bytes);
    command_t command;
    if (body && command.decode(body->data(), 0, static_cast<int>(body->size())) >= 0) obey(command);
  }
  host::HostReading read() override { return {HostTime{now_}, WallTime{kWall + now_}, now_}; }

  Duration now() const { return now_; }
  /// All that a log should hold, in order.
  const std::vector<Message>& messages() const { return messages_; }
  /// When each FIRE came.
  const std::vector<Duration>& fires() const { return fires_; }
  bool armed() const { return status_.state == status_t::ARMED; }
  /// The shots whose summaries were sent.
  const std::vector<strobe_msgs::shot_t>& shots() const { return shots_; }

 private:
  static constexpr Duration kWall = std::chrono::hours{500'000};

  void obey(const command_t& command) {
    if (command.kind == command_t::ARM && status_.state == status_t::IDLE) {
      send_event(event_t::ARMED, 0, command.host_id);
      be(status_t::ARMED, 9, command.host_id);
    } else if (command.kind == command_t::DISARM && status_.state == status_t::ARMED) {
      be(status_t::IDLE);
    } else if (command.kind == command_t::FIRE) {
      fires_.push_back(now_);
      if (status_.state == status_t::ARMED) fire(command.host_id);
    }
  }
  void fire(std::int64_t host_id) {
    const int id = ++status_.last_shot_id;
    const std::int64_t first = status_.last_sequence + 1;
    send_event(event_t::SHOT_STARTED, id);
    be(status_t::FIRING);
    after(milliseconds{600}, [this, id, host_id, first] {
      for (int i = 0; i < 5; ++i) send_event(event_t::FLASH, id);
      send_event(event_t::SHOT_ENDED, id);
      strobe_msgs::shot_t& shot = shots_.emplace_back(made_.shot);
      shot.boot_id = status_.boot_id;
      shot.host_id = host_id;
      shot.shot_id = id;
      shot.first_sequence = first;
      shot.last_sequence = status_.last_sequence;
      send(Channel::shot, shot);
      be(status_t::IDLE);
    });
    after(milliseconds{900}, [this, id] {
      strobe_msgs::frame_t frame = made_.frame;
      frame.boot_id = status_.boot_id;
      frame.shot_id = id;
      send(Channel::frame, frame);
    });
  }
  void be(std::int8_t state, std::int64_t token = 0, std::int64_t host_id = 0) {
    status_.state = state;
    status_.arm_token = token;
    status_.arm_host_id = host_id;
    send_status();
  }
  void send_status() {
    status_.mono_ns = status_.boot_time_ns = to_ns(MonoTime{now_});
    status_.wall_ns = (kWall + now_).count();
    next_status_ = now_ + milliseconds{500};
    send(Channel::status, status_);
  }
  void send_event(std::int8_t kind, int shot_id, std::int64_t host_id = 0) {
    event_t event{};
    event.schema_version = event_t::SCHEMA_VERSION;
    event.boot_id = status_.boot_id;
    event.sequence = ++status_.last_sequence;
    event.kind = kind;
    event.shot_id = shot_id;
    if (host_id != 0) event.detail = std::to_string(host_id);
    send(Channel::event, event);
  }
  template <typename Sent>
  void send(Channel channel, const Sent& message) {
    const std::string name = messages::channel_name("bench", channel);
    arriving_.emplace_back(name, lab_.packet(name, message));
  }
  void after(Duration delay, std::function<void()> action) {
    due_.emplace_back(now_ + delay, std::move(action));
  }

  authentication::Key key_;
  testing::SealedSender lab_;
  host_test::SyntheticShot made_ = host_test::make_shot({});
  Duration now_ = std::chrono::seconds{100};
  Duration next_status_{};
  status_t status_{};
  std::vector<std::pair<Duration, std::function<void()>>> due_;
  std::vector<Message> arriving_, messages_;
  std::vector<Duration> fires_;
  std::vector<strobe_msgs::shot_t> shots_;
};

}  // namespace strobe::storage
