// Raw LCM messages of one rig to typed ones. Nothing that a message holds makes it throw. Single-threaded.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>

namespace strobe::host {

/// Receives what was decoded. now_ns: the time of arrival on the caller's steady clock, or a log's.
class MessageHandler {
 public:
  virtual ~MessageHandler() = default;
  virtual void status(const strobe_msgs::status_t& message, std::int64_t now_ns) = 0;
  virtual void event(const strobe_msgs::event_t& message, std::int64_t now_ns) = 0;
  virtual void shot(const strobe_msgs::shot_t& message, std::int64_t now_ns) = 0;
  virtual void frame(const strobe_msgs::frame_t& message, std::int64_t now_ns) = 0;
};

class MessageDecoder {
 public:
  MessageDecoder(std::string_view rig, MessageHandler& sink);

  /// Decodes and hands on a message; other channels, and types that are of no version known, are
  /// counted and left. Exceptions of the sink end here, too: an LCM handler must not throw through C code.
  void receive(std::string_view channel, const void* data, std::size_t size, std::int64_t now_ns) noexcept;

  std::int64_t undecodable() const { return undecodable_; }
  /// What the last exception of the sink said; empty if there was none.
  const std::string& fault() const { return fault_; }

 private:
  void take_event(const void* data, std::size_t size, std::int64_t now_ns);
  void take_shot(const void* data, std::size_t size, std::int64_t now_ns);
  void take_status(const void* data, std::size_t size, std::int64_t now_ns);
  void take_frame(const void* data, std::size_t size, std::int64_t now_ns);

  MessageHandler& sink_;
  std::string status_, event_, shot_, frame_;
  std::int64_t undecodable_ = 0;
  std::string fault_;
};

}  // namespace strobe::host
