// Which journalled events of each boot of the firmware have arrived, and which must be requested again. A
// boot numbers its events 1, 2, 3 ... without gaps, so a missing number was lost on the way. Of more than 256
// boots the one heard longest ago is forgotten. No I/O; single-threaded.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/shot/shot_key.hpp"
#include "common/units/time.hpp"

namespace strobe::host {

/// A boot that has ended, and its journal's last event.
struct EndedBoot {
  std::int64_t boot_id = 0;
  std::int64_t last_sequence = 0;
};

class EventLedger {
 public:
  /// from_start: events before the first one received count as missing, too.
  explicit EventLedger(bool from_start) : from_start_(from_start) {}

  /// An event has arrived. Returns false if it is a duplicate or its number is below 1.
  bool add(std::int64_t boot_id, std::int64_t sequence, HostTime now);
  /// From a heartbeat: the boot that is running and its journal's last event. A change of boot means that the
  /// one before has ended.
  void status(std::int64_t boot_id, std::int64_t last_sequence, HostTime now);
  /// From a heartbeat: the boots before, newest first. All events are requested of those that were heard
  /// here and of all later ones.
  void earlier(std::span<const EndedBoot> boots, HostTime now);
  /// Requests an event although it has arrived: with it comes its shot's summary. Of a boot that has ended it
  /// is requested 24 times at most.
  void request_again(std::int64_t boot_id, std::int64_t sequence);
  /// Ends such requests.
  void cancel_request(std::int64_t boot_id, std::int64_t sequence);

  /// Ranges to request now: missing events, 0.1 s after they were noticed and then every 0.25 s; of a boot
  /// that has ended also what may follow its last known event, until eight requests brought nothing new.
  std::vector<EventRange> due(HostTime now);

  /// Events known to be missing, of all boots.
  std::int64_t missing() const;
  /// Whether nothing is missing, and no ended boot may have more.
  bool complete() const;
  /// Number of different events that have arrived.
  std::int64_t received() const;
  /// Whether all events of a range, both ends included, have arrived.
  bool holds(std::int64_t boot_id, std::int64_t first, std::int64_t last) const;
  /// Whether the boot has ended and all events of its journal have arrived, as far as can be known.
  bool ended_and_complete(std::int64_t boot_id) const;

 private:
  struct Boot {
    std::map<std::int64_t, std::int64_t>
        runs;                 ///< first to last number of each run of events that have arrived
    std::int64_t start = 0;   ///< first sequence that counts
    std::int64_t newest = 0;  ///< largest known to exist
    HostTime heard;
    HostTime gap_since;
    HostTime asked;
    std::map<std::int64_t, int> again;  ///< sequence, and how often it was asked for
    int tail_requests_left = 0;
    bool end_known = false;  ///< newest is the last one
  };

  Boot& boot_of(std::int64_t boot_id, std::int64_t start);
  void forget_one_but(std::int64_t newest);

  std::vector<EventRange> gaps(std::int64_t boot_id, const Boot& boot) const;
  static std::int64_t missing_of(const Boot& boot);
  static bool consistent(const Boot& boot);

  bool from_start_;
  std::int64_t current_boot_ = 0;
  std::map<std::int64_t, Boot> boots_;
};

}  // namespace strobe::host
