#include "host/messages/message_decoder.hpp"

#include <algorithm>
#include <exception>

#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"

namespace strobe::host {
namespace {

template <typename Message>
bool decode(Message& message, const void* data, std::size_t size) {
  return messages::decode_checked(message, data, size) && message.schema_version == Message::SCHEMA_VERSION;
}

bool numbered_in_order(const std::vector<strobe_msgs::flash_t>& flashes) {
  std::int32_t index = 0;
  return std::all_of(flashes.begin(), flashes.end(),
                     [&index](const auto& flash) { return flash.flash_index == index++; });
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
  if (decode(event, data, size) && messages::in_range(event))
    return sink_.event(event, now_ns);
  ++undecodable_;
}

void MessageDecoder::take_shot(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::shot_t shot;
  if (decode(shot, data, size) && messages::in_range(shot) && numbered_in_order(shot.flashes))
    return sink_.shot(shot, now_ns);
  ++undecodable_;
}

void MessageDecoder::take_status(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::status_t status;
  if (decode(status, data, size) && messages::in_range(status))
    return sink_.status(status, now_ns);
  ++undecodable_;
}

void MessageDecoder::take_frame(const void* data, std::size_t size, std::int64_t now_ns) {
  strobe_msgs::frame_t frame;
  if (decode(frame, data, size)) return sink_.frame(frame, now_ns);
  ++undecodable_;
}

}  // namespace strobe::host
