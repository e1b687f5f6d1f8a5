#include "host/messages/message_decoder.hpp"

#include <algorithm>
#include <exception>

#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"

namespace strobe::host {
namespace {

bool numbered_in_order(const std::vector<strobe_msgs::flash_t>& flashes) {
  std::int32_t index = 0;
  return std::all_of(flashes.begin(), flashes.end(),
                     [&index](const auto& flash) { return flash.flash_index == index++; });
}

bool valid(const strobe_msgs::frame_t&) { return true; }
bool valid(const strobe_msgs::shot_t& shot) {
  return messages::in_range(shot) && numbered_in_order(shot.flashes);
}
template <typename Message>
bool valid(const Message& message) {
  return messages::in_range(message);
}

}  // namespace

MessageDecoder::MessageDecoder(std::string_view rig, MessageHandler& handler)
    : handler_(handler),
      status_(messages::channel_name(rig, messages::Channel::status)),
      event_(messages::channel_name(rig, messages::Channel::event)),
      shot_(messages::channel_name(rig, messages::Channel::shot)),
      frame_(messages::channel_name(rig, messages::Channel::frame)) {}

void MessageDecoder::receive(std::string_view channel, std::span<const std::uint8_t> bytes) noexcept {
  try {
    if (channel == event_) {
      decode(bytes, &MessageHandler::on_event);
    } else if (channel == status_) {
      decode(bytes, &MessageHandler::on_status);
    } else if (channel == shot_) {
      decode(bytes, &MessageHandler::on_shot);
    } else if (channel == frame_) {
      decode(bytes, &MessageHandler::on_frame);
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

template <typename Message>
void MessageDecoder::decode(std::span<const std::uint8_t> bytes,
                            void (MessageHandler::*handle)(const Message&)) {
  Message message;
  if (messages::decode_checked(message, bytes.data(), bytes.size()) &&
      message.schema_version == Message::SCHEMA_VERSION && valid(message))
    return (handler_.*handle)(message);
  ++undecodable_;
}

}  // namespace strobe::host
