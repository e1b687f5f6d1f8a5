// What hosts have asked to be sent again: bounded for each host and in all, what is asked for already is not
// entered twice, and hosts are served in turn. A request that finds no place is dropped; hosts ask again.
// Not real-time; one thread's.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "common/shot/sequence_range.hpp"

namespace strobe::firmware {

struct ResendRequest {
  std::int64_t host_id = 0;
  EventRange range;
  bool this_boot = true;  ///< the range is one of the boot that is running
};

class ResendQueue {
 public:
  static constexpr std::size_t kMaxHosts = 16;
  /// For each host: so many of this boot, and as many of earlier ones.
  static constexpr std::size_t kMaxOfHost = 16;
  /// An answer's; the host asks for what follows.
  static constexpr std::int64_t kMaxEvents = 4096;

  /// Only the first kMaxEvents of the range are kept. Returns false if it was dropped: no range, or no place.
  bool add(const ResendRequest& request);
  /// The next to be answered: of this boot before earlier ones, hosts in turn.
  std::optional<EventRange> next();
  bool empty() const { return hosts_.empty(); }

 private:
  struct Host {
    std::int64_t id = 0;
    std::deque<EventRange> this_boot, earlier;
  };
  bool asked_for(const EventRange& range) const;
  Host* host(std::int64_t id);

  std::deque<Host> hosts_;  ///< with a request or more, the next to be served first
  EventRange being_answered_;
};

}  // namespace strobe::firmware
