#include "host/messages/message_decoder.hpp"

#include <algorithm>
#include <cassert>
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

using authentication::kUnverifiedCount;
using authentication::Unverified;

namespace {

constexpr Duration kQuiet = std::chrono::seconds{10};

std::string words_of(const authentication::UnverifiedCounts& now,
                     const authentication::UnverifiedCounts& before) {
  std::string text;
  for (std::size_t i = 0; i < kUnverifiedCount; ++i) {
    const auto why = static_cast<Unverified>(i);
    if (now[why] == before[why]) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(now[why] - before[why]) + " " +
            authentication::words(why);
  }
  return text;
}

}  // namespace

PacketCheck::PacketCheck(const std::optional<authentication::Key>& key, std::int64_t own_sender)
    : own_sender_(own_sender) {
  if (key) seal_.emplace(*key);
}

std::optional<PacketCheck::Bytes> PacketCheck::open(std::string_view channel, Bytes packet) {
  if (!seal_) return authentication::message_of(packet);
  const auto opened = seal_->open(channel, packet);
  if (!opened) {
    ++counts_[opened.error()];
    return std::nullopt;
  }
  if (opened->number.sender == own_sender_) return std::nullopt;
  if (!windows_.accept(opened->number)) {
    ++counts_[Unverified::replayed];
    return std::nullopt;
  }
  return opened->message;
}

std::optional<std::string> PacketCheck::due_line(HostTime now) {
  // What came twice by the network's fault is nobody's attack: it is counted, and no line's cause.
  const std::int64_t strange = counts_.sum() - counts_[Unverified::replayed];
  const std::int64_t strange_told = reported_.sum() - reported_[Unverified::replayed];
  if (strange == strange_told || (told_at_ && now - *told_at_ < kQuiet)) return std::nullopt;
  std::string line = "packets ignored that are not the lab's: " + words_of(counts_, reported_);
  if (counts_[Unverified::other_key] > reported_[Unverified::other_key])
    line += " (has that program this lab's key? see strobe key)";
  assert(strange > strange_told);
  reported_ = counts_;
  told_at_ = now;
  return line;
}

}  // namespace strobe::host
