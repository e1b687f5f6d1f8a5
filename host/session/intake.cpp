#include "host/session/intake.hpp"

#include <exception>
#include <limits>
#include <strobe_msgs/frame_v1_t.hpp>

#include "common/messages/channels.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/messages/shot_versions.hpp"
#include "common/messages/status_from_v1.hpp"
#include "common/messages/well_formed.hpp"
#include "host/session/believable.hpp"

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
  try {
    if (channel == event_) {
      take_event(data, size, now_ns);
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

void Intake::take_event(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::event_t event;
  if (messages::event_well_formed(data, size) && decode(event, data, size) && believable(event))
    return sink_.event(event, now_ns);
  ++undecodable_;
}

void Intake::take_shot(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::shot_t shot;
  const auto decoded = [&] {
    if (messages::shot_well_formed(data, size) && decode(shot, data, size)) return true;
    strobe_msgs::shot_v1_t old;  // of a log from before version 2
    if (!messages::shot_v1_well_formed(data, size) || !decode(old, data, size)) return false;
    shot = messages::shot_from_v1(old);
    return true;
  };
  if (decoded() && believable(shot)) return sink_.shot(shot, now_ns);
  ++undecodable_;
}

void Intake::take_status(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::status_t status;
  const auto decoded = [&] {
    if (messages::status_well_formed(data, size) && decode(status, data, size)) return true;
    strobe_msgs::status_v1_t old;  // of a log from before version 2
    if (!messages::status_v1_well_formed(data, size) || !decode(old, data, size)) return false;
    status = messages::status_from_v1(old);
    return true;
  };
  if (decoded() && believable(status)) return sink_.status(status, now_ns);
  ++undecodable_;
}

void Intake::take_frame(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::frame_t frame;
  if (messages::frame_well_formed(data, size) && decode(frame, data, size)) return sink_.frame(frame, now_ns);
  strobe_msgs::frame_v1_t old;  // of a log from before version 2
  if (messages::frame_v1_well_formed(data, size) && decode(old, data, size))
    return sink_.frame(messages::frame_from_v1(old), now_ns);
  ++undecodable_;
}

}  // namespace strobe::host
