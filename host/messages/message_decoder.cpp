#include "host/messages/message_decoder.hpp"

#include <exception>
#include <strobe_msgs/frame_v1_t.hpp>

#include "common/messages/channels.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/messages/shot_versions.hpp"
#include "common/messages/status_from_v1.hpp"
#include "common/messages/well_formed.hpp"
#include "host/messages/in_range.hpp"

namespace strobe::host {
namespace {

using WellFormed = bool (*)(const void*, std::size_t);

template <typename Message>
bool decode(Message& message, WellFormed well_formed, const void* data, std::size_t size) {
  return messages::decode_checked(message, well_formed, data, size) &&
         message.schema_version == Message::SCHEMA_VERSION;
}

/// A message of this version, or one of a log from before it.
template <typename Message, typename Old>
bool decode(Message& message, WellFormed well_formed, Message (*from_old)(const Old&),
            WellFormed old_well_formed, const void* data, std::size_t size) {
  if (decode(message, well_formed, data, size)) return true;
  Old old;
  if (!decode(old, old_well_formed, data, size)) return false;
  message = from_old(old);
  return true;
}

}  // namespace

MessageDecoder::MessageDecoder(std::string_view rig, MessageHandler& sink)
    : sink_(sink),
      status_(messages::channel_name(rig, messages::Channel::status)),
      event_(messages::channel_name(rig, messages::Channel::event)),
      shot_(messages::channel_name(rig, messages::Channel::shot)),
      frame_(messages::channel_name(rig, messages::Channel::frame)) {}

void MessageDecoder::receive(std::string_view channel, const void* data, std::size_t size,
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

void MessageDecoder::take_event(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::event_t event;
  if (decode(event, messages::event_well_formed, data, size) && in_range(event))
    return sink_.event(event, now_ns);
  ++undecodable_;
}

void MessageDecoder::take_shot(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::shot_t shot;
  if (decode(shot, messages::shot_well_formed, messages::shot_from_v1, messages::shot_v1_well_formed, data,
             size) &&
      in_range(shot))
    return sink_.shot(shot, now_ns);
  ++undecodable_;
}

void MessageDecoder::take_status(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::status_t status;
  if (decode(status, messages::status_well_formed, messages::status_from_v1, messages::status_v1_well_formed,
             data, size) &&
      in_range(status))
    return sink_.status(status, now_ns);
  ++undecodable_;
}

void MessageDecoder::take_frame(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::frame_t frame;
  if (decode(frame, messages::frame_well_formed, messages::frame_from_v1, messages::frame_v1_well_formed,
             data, size))
    return sink_.frame(frame, now_ns);
  ++undecodable_;
}

}  // namespace strobe::host
