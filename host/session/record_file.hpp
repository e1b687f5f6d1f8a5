// A file that grows by whole records. A record that cannot be written leaves nothing of itself behind: what
// was written of it is cut off again. It waits in memory with those that follow and is tried again, in order.
// The caller is told of every failure, and sees to it that nobody else writes the file (run_lock.hpp). Writes
// a file; one thread's.
#pragma once

#include <sys/types.h>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/result.hpp"

namespace strobe::host {

class RecordFile {
 public:
  /// So much waits; what comes then is lost, and counted.
  static constexpr std::size_t kMaxWaiting_bytes = std::size_t{64} << 20;

  enum class Use {
    anew,    ///< a file that did not exist
    append,  ///< to what is there, if any
  };
  /// Fails with the path and the system's reason, which errno has, too.
  static Result<RecordFile> open(const std::filesystem::path& path, Use use);

  RecordFile(RecordFile&& other) noexcept;
  RecordFile& operator=(RecordFile&&) = delete;
  ~RecordFile();

  const std::filesystem::path& path() const { return path_; }
  int fd() const { return fd_; }

  /// kind: what it is, for unstored(). Fails if it could not be written yet.
  Result<void> append(std::string record, std::string_view kind);
  /// Writes what waits.
  Result<void> retry();
  /// Returns once what was written is on the disk. A disk that fails in this may have lost any of it, and
  /// does not say so again: all later calls fail, too.
  Result<void> sync();
  /// Whether what is written still reaches a file of this name.
  Result<void> still_there() const;
  /// Writes what waits, syncs, closes. Fails as these do.
  Result<void> close();

  /// Records not written, by kind.
  std::map<std::string, int> unstored() const;
  /// Why what was written is not certain to last; empty: there is no reason.
  const std::string& doubt() const { return doubt_; }

  /// Cuts the file off there, unless another process has appended to it since it had this size.
  bool cut(off_t to, off_t size);

 private:
  struct Waiting {
    std::string record;
    std::string kind;
  };
  RecordFile(std::filesystem::path path, int fd) : path_(std::move(path)), fd_(fd) {}
  bool write_whole(const std::string& record);
  bool mend();
  tl::unexpected<Error> because() const;
  tl::unexpected<Error> doubtful(std::string why);

  std::filesystem::path path_;
  int fd_ = -1;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
  std::map<std::string, int> lost_;
  std::optional<std::pair<off_t, off_t>>
      torn_;  ///< from, to: what a failed write left and could not be cut off
  std::string doubt_;
};

/// A table of comma-separated values that grows by whole lines over any number of runs.
class CsvFile {
 public:
  /// Opens for appending; writes the header if the file is new. A last line without its end is closed if it
  /// has all columns, as a person's editor may leave it; else a write was cut short there, and it is removed.
  /// A file with the header of an earlier version, which lacked the last columns, keeps it: they are then
  /// left out of each line, and must hold no commas. Fails if the file has any other header, or cannot be
  /// read or written.
  static Result<CsvFile> open(const std::filesystem::path& path, const std::string& header,
                              const std::vector<std::string>& earlier = {});

  /// One write per line, or lines. What cannot be written waits and is
  /// tried again (record_file.hpp).
  Result<void> append(const std::string& line);

  /// Columns at the end of the header that the file, an earlier version's, does not have.
  std::size_t left_out() const { return static_cast<std::size_t>(left_out_); }

  RecordFile& file() { return file_; }
  const RecordFile& file() const { return file_; }

 private:
  CsvFile(RecordFile file, std::ptrdiff_t left_out) : file_(std::move(file)), left_out_(left_out) {}

  RecordFile file_;
  std::ptrdiff_t left_out_ = 0;  ///< columns at the end of a line that the file does not have
};

}  // namespace strobe::host
