// Decodes the LCM messages of one rig and hands them on by their type. Single-threaded; never throws.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include "common/authentication/packet_seal.hpp"
#include "common/authentication/replay_window.hpp"
#include "common/units/time.hpp"

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

// Which packets a host acts on. With the lab's key: those sealed with it, each once. What else comes costs
// one check and no memory, is counted, and told in one line in ten seconds at most. Without a key nothing can
// be told apart, and every packet is taken as it is. Single-threaded.

class PacketCheck {
 public:
  using Bytes = authentication::Bytes;

  /// own_sender: this host, whose packets come back by multicast.
  PacketCheck(const std::optional<authentication::Key>& key, std::int64_t own_sender);

  /// The message in a packet, a part of it. Absent if it must not be acted on, or is this host's own.
  std::optional<Bytes> open(std::string_view channel, Bytes packet);

  const authentication::UnverifiedCounts& unverified() const { return counts_; }
  /// What was not acted on since the last line, for a person; absent: nothing, or it is not yet time.
  std::optional<std::string> due_line(HostTime now);

 private:
  std::optional<authentication::PacketSeal> seal_;
  std::int64_t own_sender_;
  authentication::ReplayWindows windows_;
  authentication::UnverifiedCounts counts_, reported_;
  std::optional<HostTime> told_at_;
};

}  // namespace strobe::host
