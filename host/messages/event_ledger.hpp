// Which journalled events of each firmware start have arrived, and which must be asked for again.
// Sequences of one boot are 1, 2, 3 ... without gaps, so what is not here was lost on the way.
// Times are nanoseconds of any steady clock of the caller's. No I/O; single-threaded.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/shot/sequence_range.hpp"

namespace strobe::host {

/// A boot that has ended, and how far its journal has come.
struct EndedBoot {
  std::int64_t boot_id = 0;
  std::int64_t last_sequence = 0;
};

class EventLedger {
 public:
  /// from_start: events before the first one heard count as missing too.
  explicit EventLedger(bool from_start) : from_start_(from_start) {}

  /// An event has arrived. False: it had been here before, or is not a sequence.
  bool add(std::int64_t boot_id, std::int64_t sequence, std::int64_t now_ns);
  /// The firmware that runs now says how far its journal has come. Another boot than before: the old one has
  /// ended.
  void status(std::int64_t boot_id, std::int64_t last_sequence, std::int64_t now_ns);
  /// The firmware that runs now says what earlier starts have left, the newest first. Of those that were
  /// heard here, and of all that came after one of them, everything is wanted.
  void earlier(std::span<const EndedBoot> boots, std::int64_t now_ns);
  /// This event must come again although it has been here (its shot's summary was lost). Of a boot that has
  /// ended it is asked for 24 times.
  void request_again(std::int64_t boot_id, std::int64_t sequence);
  /// It is not to be had.
  void cancel_request(std::int64_t boot_id, std::int64_t sequence);

  /// Ranges to ask for now. Losses are asked for after a grace for reordering, then again and again; of a
  /// boot that has ended, what may be behind its last event is asked for until nothing new comes.
  std::vector<EventRange> due(std::int64_t now_ns);

  /// Events known to be missing, of all boots.
  std::int64_t missing() const;
  /// Nothing is missing, and no ended boot may hold more.
  bool complete() const;
  std::int64_t received() const;
  /// All events of a range are here.
  bool holds(std::int64_t boot_id, std::int64_t first, std::int64_t last) const;
  /// The boot has ended, and all that its journal holds is here, as far as that can be known.
  bool ended_and_complete(std::int64_t boot_id) const;

 private:
  struct Boot {
    std::map<std::int64_t, std::int64_t> have;  ///< first -> last of each run of sequences
    std::int64_t start = 0;                     ///< first sequence that counts
    std::int64_t newest = 0;                    ///< largest known to exist
    std::int64_t gap_since_ns = 0;
    std::int64_t asked_ns = 0;
    std::map<std::int64_t, int> again;  ///< sequence, and how often it was asked for
    int tail_requests_left = 0;
    bool end_known = false;  ///< newest is the last one
  };

  Boot& boot_of(std::int64_t boot_id, std::int64_t start);

  std::vector<EventRange> gaps(std::int64_t boot_id, const Boot& boot) const;
  static std::int64_t missing_of(const Boot& boot);

  bool from_start_;
  std::int64_t current_boot_ = 0;
  std::map<std::int64_t, Boot> boots_;
};

}  // namespace strobe::host
