// The journal: a standard LCM log, one file per boot, DIR/journal-<boot id in hex>.lcmlog. Each append is one
// write, so that what was appended survives the process; sync() makes it survive the machine. A file's torn
// tail (the machine's death) is left as it is. Not real-time; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "firmware/publisher/log_reader.hpp"
#include "firmware/publisher/messages.hpp"

namespace strobe::firmware {

/// One encoded message. An event has its sequence in both ends of `sequences`, a shot its first and last
/// event's.
struct Message {
  enum class Kind { event, shot } kind = Kind::event;
  SequenceRange sequences;
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

/// Where a message begins in a journal.
struct JournalEntry {
  Message::Kind kind = Message::Kind::event;
  SequenceRange sequences;
  std::int64_t offset = 0;
};

std::filesystem::path journal_path(const std::filesystem::path& dir, std::int64_t boot_id);

class Journal {
 public:
  /// Makes the folder if need be. Error: names the path and the cause.
  static Result<Journal> create(const std::filesystem::path& dir, std::int64_t boot_id);
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&&) = delete;
  ~Journal();

  /// All or nothing: on failure the file is cut back to what it was.
  Result<void> append(const std::vector<Message>& messages, std::int64_t wall_us);
  Result<void> sync();
  /// Whether the file can still be found and written.
  Result<void> check() const;

  const std::filesystem::path& path() const { return path_; }
  const std::vector<JournalEntry>& entries() const { return entries_; }

 private:
  Journal(std::filesystem::path path, int fd) : path_(std::move(path)), fd_(fd) {}

  std::filesystem::path path_;
  int fd_ = -1;
  std::int64_t size_ = 0;
  std::int64_t count_ = 0;
  std::vector<JournalEntry> entries_;
};

/// The entries of a journal of an earlier boot; see LogReader for damaged ones.
std::vector<JournalEntry> scan_journal(const std::filesystem::path& path);
/// The message at an entry's place, also in a journal that is still being written; empty bytes: it cannot be
/// read.
Message read_entry(LogReader& reader, const JournalEntry& entry);
/// Largest shot id in the folder's journals; 0: none.
std::int32_t last_shot_id(const std::filesystem::path& dir);

}  // namespace strobe::firmware
