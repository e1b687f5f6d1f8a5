// What hosts have asked to be sent again: bounded for each host and in all, what is asked for already is not
// entered twice, and hosts are served in turn. A request that finds no place is dropped; hosts ask again.
// Not real-time; one thread's.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "common/shot/shot_key.hpp"
#include "firmware/publisher/journal.hpp"

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

/// Finds and reads the messages of a range of events in a journal. The journal is its own index: it is in
/// order of sequences, so that its first record of the range is found by halving, each time from the next
/// whole record. Nothing can be out of date or torn that the journal itself is not, and no memory grows with
/// its size. Works in bounded steps, also on a journal that is still being written or is damaged. Not
/// real-time; one thread's.
class RangeReader {
 public:
  /// Where there is no such file, or it cannot be read, the range has no messages.
  RangeReader(const std::filesystem::path& path, const SequenceRange& wanted);

  enum class Step { message, searching, done };
  /// Reads at most one record and wire::LogReader::kPart_bytes of the file. `message`: the next of the
  /// range's events, or of the shots that any of them belongs to.
  Step step(wire::LogRecord& record);
  /// From the file so far.
  std::int64_t bytes_read() const { return log_.bytes_read(); }

 private:
  bool found() const { return end_ - begin_ <= static_cast<std::int64_t>(wire::LogReader::kPart_bytes); }
  void halve();
  void narrow(std::int64_t begin, std::int64_t end);
  Step collect(wire::LogRecord& record);

  wire::LogReader log_;
  SequenceRange wanted_;
  /// The first record of the range begins here or behind, ...
  std::int64_t begin_ = 0;
  std::int64_t end_ = 0;      ///< ... and not behind this
  std::int64_t middle_ = 0;   ///< where the search for a record between them began
  std::int32_t shot_id_ = 0;  ///< of the last event that was given
  bool over_ = false;
};

}  // namespace strobe::firmware
