// The journal: a standard LCM log, one file per boot, DIR/journal-<boot id in hex>.lcmlog. Each append is one
// write, so that what was appended survives the process; sync() makes it survive the machine. The file is
// locked (flock) while it is open, so that no other daemon repairs it. Not real-time; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/wire/log_reader.hpp"
#include "firmware/publisher/messages.hpp"

namespace strobe::firmware {

/// One encoded message. `sequences`: of an event its own, of a shot those of its first and last event.
struct Message {
  enum class Kind { event, shot } kind = Kind::event;
  SequenceRange sequences;
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

/// What a record of a journal is. A journal is in order of its entries' last sequences.
struct JournalEntry {
  Message::Kind kind = Message::Kind::event;
  SequenceRange sequences;
  std::int32_t shot_id = 0;  ///< 0: outside a shot
};

/// Sixteen digits, as in the journal's name.
std::string boot_in_hex(std::int64_t boot_id);
std::filesystem::path journal_path(const std::filesystem::path& dir, std::int64_t boot_id);

class Journal {
 public:
  /// Disk space that a shot may need [bytes]: 4,000 events and the summary. A shot of 200 flashes takes
  /// 90,000.
  static constexpr std::int64_t kShotRoom = std::int64_t{512} << 10;

  /// Creates the folder if it does not exist. Fails with the path and the cause.
  static Result<Journal> create(const std::filesystem::path& dir, std::int64_t boot_id);
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&&) = delete;
  ~Journal();

  /// All or nothing: on failure the file is truncated to what it was.
  Result<void> append(const std::vector<Message>& messages, std::int64_t wall_us);
  /// After a failure the journal stays broken: the system may have dropped what it could not write.
  Result<void> sync();
  /// Fails, saying what happened and what to do, if the file was moved, removed, replaced or changed by
  /// others or the folder is not writable: what is appended might not be found again.
  Result<void> check() const;
  /// Reserves disk space for a shot, unless it already is. Fails if there is too little, or none to list this
  /// start.
  Result<void> make_room();

  const std::filesystem::path& path() const { return path_; }

 private:
  Journal(std::filesystem::path path, int fd, std::int64_t boot_id)
      : path_(std::move(path)), fd_(fd), boot_id_(boot_id) {}
  Result<void> list_start();
  Result<void> free_room() const;

  std::filesystem::path path_;
  int fd_ = -1;
  std::int64_t boot_id_ = 0;
  bool listed_ = false;  ///< in the folder's order of starts
  std::int64_t size_ = 0;
  std::int64_t reserved_ = 0;  ///< up to here the file's space is reserved [bytes]
  std::int64_t count_ = 0;
  std::string broken_;
};

/// Returns nullopt unless the record is an event or a shot that can be decoded.
std::optional<JournalEntry> entry_of(const wire::LogRecord& record);

/// Looks through a whole journal for damage between its records, in bounded steps.
class DamageCheck {
 public:
  DamageCheck(const std::filesystem::path& path, std::int64_t boot_id) : log_(path), boot_id_(boot_id) {}

  /// Reads at most one record and wire::LogReader::kPart_bytes of the file. Returns false at its end.
  bool step();
  /// What was found so far, in words of at most 160 characters; empty: nothing. What follows the last whole
  /// record is not counted.
  std::string finding() const;
  /// From the file so far.
  std::int64_t bytes_read() const { return log_.bytes_read(); }

 private:
  wire::LogReader log_;
  wire::LogRecord record_;
  std::int64_t boot_id_;
  std::int64_t whole_end_ = 0;  ///< where the last whole record ends
  std::int64_t damaged_ = 0;    ///< bytes between whole records
};

}  // namespace strobe::firmware
