#include "tests/campaigns/scripted_bench.hpp"

#include <strobe_msgs/event_t.hpp>

#include <algorithm>

#include "common/authentication/seal.hpp"
#include "common/messages/encode.hpp"

namespace strobe::storage {

using messages::Channel;
using strobe_msgs::command_t;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

ScriptedBench::ScriptedBench(authentication::Key key, int shots_before) : key_(std::move(key)), lab_(key_) {
  status_.schema_version = status_t::SCHEMA_VERSION;
  status_.boot_id = kBoot + shots_before;
  status_.key_active = status_.journal_ok = status_.real_time = true;
  status_.last_shot_id = shots_before;
}

template <typename Sent>
void ScriptedBench::send(Channel channel, const Sent& message) {
  const std::string name = messages::channel_name("bench", channel);
  arriving_.emplace_back(name, lab_.packet(name, message));
}

void ScriptedBench::send_status() {
  status_.mono_ns = status_.boot_time_ns = to_ns(MonoTime{now_});
  status_.wall_ns = (kWall + now_).count();
  next_status_ = now_ + milliseconds{500};
  send(Channel::status, status_);
}

void ScriptedBench::send_event(std::int8_t kind, int shot_id, std::int64_t host_id) {
  event_t event{};
  event.schema_version = event_t::SCHEMA_VERSION;
  event.boot_id = status_.boot_id;
  event.sequence = ++status_.last_sequence;
  event.kind = kind;
  event.shot_id = shot_id;
  if (host_id != 0) event.detail = std::to_string(host_id);
  send(Channel::event, event);
}

void ScriptedBench::fire(std::int64_t host_id) {
  fires_.push_back(now_);
  if (status_.state != status_t::ARMED) return;
  status_.state = status_t::FIRING;
  status_.arm_token = status_.arm_host_id = 0;
  const int id = ++status_.last_shot_id;
  first_of_shot_ = status_.last_sequence + 1;
  send_event(event_t::SHOT_STARTED, id);
  send_status();
  after(milliseconds{600}, [this, id, host_id] {
    for (int i = 0; i < 5; ++i) send_event(event_t::FLASH, id);
    send_event(event_t::SHOT_ENDED, id);
    strobe_msgs::shot_t shot = made_.shot;
    shot.boot_id = status_.boot_id;
    shot.host_id = host_id;
    shot.shot_id = id;
    shot.first_sequence = first_of_shot_;
    shot.last_sequence = status_.last_sequence;
    shots_.push_back(shot);
    send(Channel::shot, shot);
    status_.state = status_t::IDLE;
    send_status();
  });
  after(milliseconds{900}, [this, id] {
    strobe_msgs::frame_t frame = made_.frame;
    frame.boot_id = status_.boot_id;
    frame.shot_id = id;
    send(Channel::frame, frame);
  });
}

void ScriptedBench::obey(const command_t& command) {
  if (command.kind == command_t::ARM && status_.state == status_t::IDLE) {
    send_event(event_t::ARMED, 0, command.host_id);
    status_.state = status_t::ARMED;
    status_.arm_host_id = command.host_id;
    status_.arm_token = 9;
    send_status();
  } else if (command.kind == command_t::DISARM && status_.state == status_t::ARMED) {
    status_.state = status_t::IDLE;
    status_.arm_host_id = status_.arm_token = 0;
    send_status();
  } else if (command.kind == command_t::FIRE) {
    fire(command.host_id);
  }
}

bool ScriptedBench::receive(std::chrono::milliseconds, std::span<const int>, const Receiver& receiver) {
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

void ScriptedBench::publish(const std::string& channel, Bytes bytes) {
  messages_.emplace_back(channel, std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
  if (channel != messages::channel_name("bench", Channel::command)) return;
  const auto body = authentication::unseal(key_, "bench", bytes);
  command_t command;
  if (body && command.decode(body->data(), 0, static_cast<int>(body->size())) >= 0) obey(command);
}

}  // namespace strobe::storage
