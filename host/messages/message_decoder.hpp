// Decodes the LCM messages of one rig and hands them on by their type. Single-threaded; never throws.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>

namespace strobe::host {

class MessageHandler {
 public:
  virtual ~MessageHandler() = default;
  virtual void on_status(const strobe_msgs::status_t& message) = 0;
  virtual void on_event(const strobe_msgs::event_t& message) = 0;
  virtual void on_shot(const strobe_msgs::shot_t& message) = 0;
  virtual void on_frame(const strobe_msgs::frame_t& message) = 0;
};

class MessageDecoder {
 public:
  MessageDecoder(std::string_view rig, MessageHandler& handler);

  /// Other channels are ignored. Messages that cannot be decoded, are of no known version or hold numbers out
  /// of range are counted and ignored. Exceptions of the handler end here: they must not pass through LCM.
  void receive(std::string_view channel, std::span<const std::uint8_t> bytes) noexcept;

  std::int64_t undecodable() const { return undecodable_; }
  /// What the last exception of the handler said; empty if there was none.
  const std::string& fault() const { return fault_; }

 private:
  template <typename Message>
  void decode(std::span<const std::uint8_t> bytes, void (MessageHandler::*handle)(const Message&));

  MessageHandler& handler_;
  std::string status_, event_, shot_, frame_;
  std::int64_t undecodable_ = 0;
  std::string fault_;
};

}  // namespace strobe::host
