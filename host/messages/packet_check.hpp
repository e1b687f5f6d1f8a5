// Which packets a host acts on. With the lab's key: those sealed with it, each once. What else comes costs one
// check and no memory, is counted, and told in one line in ten seconds at most. Without a key nothing can be
// told apart, and every packet is taken as it is. Single-threaded.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/authentication/packet_seal.hpp"
#include "common/authentication/replay_window.hpp"
#include "common/units/time.hpp"

namespace strobe::host {

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
  authentication::UnverifiedCounts counts_, told_;
  std::optional<HostTime> told_at_;
};

}  // namespace strobe::host
