#include "host/session/record_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "common/config/files.hpp"
#include "common/data/csv.hpp"

namespace strobe::host {
namespace {

std::optional<off_t> size_of(int fd) {
  struct stat status {};
  return ::fstat(fd, &status) == 0 ? std::optional(status.st_size) : std::nullopt;
}

}  // namespace

tl::unexpected<Error> RecordFile::because() const {
  return fail(path_.string() + ": cannot be written: " + std::strerror(errno));
}

tl::unexpected<Error> RecordFile::doubtful(std::string why) {
  if (doubt_.empty()) doubt_ = std::move(why);
  return fail(path_.string() + ": " + doubt_);
}

Result<RecordFile> RecordFile::open(const std::filesystem::path& path, Use use) {
  const int flags = use == Use::anew ? O_WRONLY | O_EXCL : O_RDWR;
  const int fd = ::open(path.c_str(), flags | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (fd < 0) return fail(path.string() + ": cannot be written: " + std::strerror(errno));
  return RecordFile(path, fd);
}

RecordFile::RecordFile(RecordFile&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      waiting_(std::move(other.waiting_)),
      waiting_bytes_(other.waiting_bytes_),
      lost_(std::move(other.lost_)),
      torn_(other.torn_),
      doubt_(std::move(other.doubt_)) {}

RecordFile::~RecordFile() {
  if (fd_ >= 0) ::close(fd_);
}

Result<void> RecordFile::append(std::string record, std::string_view kind) {
  if (waiting_bytes_ + record.size() > kMaxWaiting_bytes) {
    ++lost_[std::string(kind)];
    return fail(path_.string() +
                fmt::format(": {} MB wait for the disk, and no more are kept", kMaxWaiting_bytes >> 20));
  }
  waiting_bytes_ += record.size();
  waiting_.push_back({std::move(record), std::string(kind)});
  return retry();
}

Result<void> RecordFile::retry() {
  while (!waiting_.empty()) {
    if (!write_whole(waiting_.front().record)) return because();
    assert(waiting_bytes_ >= waiting_.front().record.size());
    waiting_bytes_ -= waiting_.front().record.size();
    waiting_.pop_front();
  }
  return {};
}

bool RecordFile::cut(off_t to, off_t size) {
  const auto now = size_of(fd_);
  return now && (*now != size || ::ftruncate(fd_, to) == 0);
}

bool RecordFile::mend() {
  if (torn_ && !cut(torn_->first, torn_->second)) return false;
  torn_.reset();
  return true;
}

bool RecordFile::write_whole(const std::string& record) {
  if (!mend()) return false;
  const auto before = size_of(fd_);
  if (!before) return false;
  if (config::write_all(fd_, record)) return true;
  const int why = errno;
  const auto after = size_of(fd_);
  if (!after || (*after > *before && ::ftruncate(fd_, *before) != 0))
    torn_ = {*before, after.value_or(*before + static_cast<off_t>(record.size()))};
  errno = why;
  return false;
}

Result<void> RecordFile::sync() {
  if (!doubt_.empty()) return doubtful("");
  int failed = 0;
  do failed = ::fsync(fd_);
  while (failed != 0 && errno == EINTR);
  if (failed != 0 && errno != EINVAL && errno != ENOTSUP)
    return doubtful(std::string("what was written last may be lost: ") + std::strerror(errno));
  return {};
}

Result<void> RecordFile::still_there() const {
  struct stat here {
  }, there{};
  if (::fstat(fd_, &here) != 0 || ::stat(path_.c_str(), &there) != 0)
    return fail(path_.string() + ": is no longer there: " + std::strerror(errno));
  if (here.st_ino == there.st_ino && here.st_dev == there.st_dev) return {};
  return fail(path_.string() + ": is no longer there: another file has its name");
}

Result<void> RecordFile::close() {
  if (fd_ < 0) return {};
  const auto written = retry();
  const auto there = still_there();
  const auto synced = sync();
  if (::close(std::exchange(fd_, -1)) != 0)
    return doubtful(std::string("what was written last may be lost: ") + std::strerror(errno));
  if (!written) return written;
  return there ? synced : there;
}

std::map<std::string, int> RecordFile::unstored() const {
  std::map<std::string, int> kinds = lost_;
  for (const Waiting& waiting : waiting_) ++kinds[waiting.kind];
  return kinds;
}

namespace {

std::ptrdiff_t columns(std::string_view line) { return std::ssize(data::csv_cells(line)); }

/// What of a file tells how it goes on.
struct Ends {
  std::string first;                ///< line, without its end
  std::optional<std::string> last;  ///< if it has no end
  off_t size = 0;
};

Result<Ends> ends_of(const std::filesystem::path& path) {
  std::optional<std::string> first;
  Ends ends;
  const auto read = config::read_lines(path, [&](std::string_view line, bool ended) {
    if (!first) first = line;
    if (!ended) ends.last = line;
    ends.size += static_cast<off_t>(line.size() + (ended ? 1 : 0));
  });
  if (!read) return tl::unexpected(read.error());
  ends.first = std::move(first).value_or("");
  return ends;
}

/// full: the number of columns.
Result<void> mend(RecordFile& file, const Ends& ends, std::ptrdiff_t full) {
  if (!ends.last) return {};
  if (columns(*ends.last) == full) return file.append("\n", "line's end");
  if (file.cut(ends.size - static_cast<off_t>(ends.last->size()), ends.size)) return {};
  return fail(file.path().string() + ": a torn line cannot be removed: " + std::strerror(errno));
}

}  // namespace

Result<CsvFile> CsvFile::open(const std::filesystem::path& path, const std::string& header,
                              const std::vector<std::string>& earlier) {
  auto file = RecordFile::open(path, RecordFile::Use::append);
  if (!file) return tl::unexpected(file.error());
  const auto ends = ends_of(path);
  if (!ends) return tl::unexpected(ends.error());
  const std::string& first = ends->first;
  // Cut short, or not yet written.
  const bool is_earlier = std::ranges::find(earlier, first) != earlier.end();
  const bool unfinished =
      static_cast<off_t>(first.size()) == ends->size && header.starts_with(first) && !is_earlier;
  if (!unfinished && first != header && !is_earlier)
    return fail(path.string() + ":1: another version's columns; use another session folder");
  if (unfinished) {
    if (!file->cut(0, ends->size))
      return fail(path.string() + ": cannot be written: " + std::strerror(errno));
    if (auto written = file->append(header + "\n", "header"); !written)
      return tl::unexpected(written.error());
    return CsvFile(std::move(*file), 0);
  }
  if (auto mended = mend(*file, *ends, columns(first)); !mended) return tl::unexpected(mended.error());
  return CsvFile(std::move(*file), columns(header) - columns(first));
}

Result<void> CsvFile::append(const std::string& line) {
  std::string kept = line;
  for (std::ptrdiff_t i = 0; i < left_out_; ++i) kept.resize(kept.rfind(','));
  return file_.append(kept + "\n", "lines");
}

}  // namespace strobe::host
