#include "host/session/intake.hpp"

#include <exception>
#include <limits>
#include <strobe_msgs/frame_v1_t.hpp>

#include "common/messages/channels.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/messages/shot_versions.hpp"
#include "common/messages/status_from_v1.hpp"
#include "host/session/counts.hpp"

namespace strobe::host {
namespace {

template <typename Message>
bool decode(Message& message, const void* data, std::size_t size) {
  if (size > static_cast<std::size_t>(std::numeric_limits<int>::max())) return false;
  return message.decode(data, 0, static_cast<int>(size)) >= 0 &&
         message.schema_version == Message::SCHEMA_VERSION;
}

}  // namespace

Intake::Intake(std::string_view rig, MessageSink& sink)
    : sink_(sink),
      status_(messages::channel_name(rig, messages::Channel::status)),
      event_(messages::channel_name(rig, messages::Channel::event)),
      shot_(messages::channel_name(rig, messages::Channel::shot)),
      frame_(messages::channel_name(rig, messages::Channel::frame)) {}

void Intake::receive(std::string_view channel, const void* data, std::size_t size,
                     std::int64_t now_ns) noexcept {
  const auto take = [&]<typename Message>(Message message,
                                          void (MessageSink::*hand_on)(const Message&, std::int64_t)) {
    if (decode(message, data, size)) {
      (sink_.*hand_on)(message, now_ns);
    } else {
      ++undecodable_;
    }
  };
  try {
    if (channel == event_) {
      take(strobe_msgs::event_t{}, &MessageSink::event);
    } else if (channel == status_) {
      take_status(data, size, now_ns);
    } else if (channel == shot_) {
      take_shot(data, size, now_ns);
    } else if (channel == frame_) {
      take_frame(data, size, now_ns);
    }
  } catch (const std::exception& error) {
    ++undecodable_;
    try {
      fault_ = error.what();
    } catch (...) {
      fault_.clear();
    }
  }
}

void Intake::take_shot(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::shot_t shot;
  if (shot_counts_plausible(data, size) && decode(shot, data, size)) return sink_.shot(shot, now_ns);
  strobe_msgs::shot_v1_t old;  // of a log from before version 2
  if (shot_v1_counts_plausible(data, size) && decode(old, data, size))
    return sink_.shot(messages::shot_from_v1(old), now_ns);
  ++undecodable_;
}

void Intake::take_status(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::status_t status;
  if (status_counts_plausible(data, size) && decode(status, data, size)) return sink_.status(status, now_ns);
  strobe_msgs::status_v1_t old;  // of a log from before version 2
  if (decode(old, data, size)) return sink_.status(messages::status_from_v1(old), now_ns);
  ++undecodable_;
}

void Intake::take_frame(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::frame_t frame;
  if (frame_counts_plausible(data, size) && decode(frame, data, size)) return sink_.frame(frame, now_ns);
  strobe_msgs::frame_v1_t old;  // of a log from before version 2
  if (frame_v1_counts_plausible(data, size) && decode(old, data, size))
    return sink_.frame(messages::frame_from_v1(old), now_ns);
  ++undecodable_;
}

}  // namespace strobe::host
