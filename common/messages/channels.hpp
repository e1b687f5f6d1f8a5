// Names of the LCM channels: STROBE/<rig>/<KIND>. Pure functions, thread-safe; they allocate.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace strobe::messages {

/// The buffer is large enough that the socket loses no event at a rig's rates; ttl 0: this machine only.
inline constexpr const char* kDefaultLcmUrl = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";

/// LCM drops silently when a subscription's queue (30 by default) is full; a shot has some 700 events.
inline constexpr int kSubscriptionQueueCapacity = 10000;

enum class Channel { command, event, status, shot, frame, readout };

inline constexpr std::array kChannelKinds{"COMMAND", "EVENT", "STATUS", "SHOT", "FRAME", "READOUT"};

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
  return "STROBE/" + std::string(rig) + "/" + kChannelKinds[static_cast<std::size_t>(channel)];
}

}  // namespace strobe::messages
