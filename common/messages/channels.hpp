// Names of the LCM channels: STROBE/<rig>/<KIND>. Pure functions, thread-safe; they allocate.
#pragma once

#include <string>

namespace strobe::messages {

/// The buffer is large enough that the socket loses no event at a rig's rates; ttl 0: this machine only.
inline constexpr const char* kDefaultLcmUrl = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";

/// LCM drops silently when a subscription's queue (30 by default) is full; a shot has some 700 events.
inline constexpr int kSubscriptionQueueCapacity = 10000;

enum class Channel { command, event, status, shot, frame, readout };

constexpr std::string_view kind_name(Channel channel) {
  switch (channel) {
    case Channel::command:
      return "COMMAND";
    case Channel::event:
      return "EVENT";
    case Channel::status:
      return "STATUS";
    case Channel::shot:
      return "SHOT";
    case Channel::frame:
      return "FRAME";
    case Channel::readout:
      return "READOUT";
  }
  return "UNKNOWN";
}

/// A rig's name: 1 to 24 of [A-Za-z0-9_-]. LCM limits a channel's name to 63 characters.
constexpr bool valid_rig_name(std::string_view rig) {
  if (rig.empty() || rig.size() > 24) return false;
  for (const char c : rig) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!letter && !(c >= '0' && c <= '9') && c != '_' && c != '-') return false;
  }
  return true;
}

inline std::string channel_name(std::string_view rig, Channel channel) {
  return "STROBE/" + std::string(rig) + "/" + std::string(kind_name(channel));
}

}  // namespace strobe::messages
