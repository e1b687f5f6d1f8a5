// Finds and reads the messages of a range of events in a journal. The journal is its own index: it is in order
// of sequences, so that its first record of the range is found by halving, each time from the next whole record.
// Nothing can be out of date or torn that the journal itself is not, and no memory grows with its size. Works in
// bounded steps, also on a journal that is still being written or is damaged. Not real-time; one thread's.
#pragma once

#include "firmware/publisher/journal.hpp"

namespace strobe::firmware {

class RangeReader {
 public:
  /// Where there is no such file, or it cannot be read, the range has no messages.
  RangeReader(const std::filesystem::path& path, const SequenceRange& wanted);

  enum class Step { message, searching, done };
  /// Reads at most one record and wire::LogReader::kPart_bytes of the file. `message`: the next of the range's events,
  /// or of the shots that any of them belongs to.
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
