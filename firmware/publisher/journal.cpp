#include "firmware/publisher/journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/shot_t.hpp>

#include "common/config/files.hpp"
#include "common/messages/well_formed.hpp"
#include "common/wire/lcm_log_record.hpp"
#include "firmware/publisher/journal_folder.hpp"

namespace strobe::firmware {

std::optional<JournalEntry> entry_of(const wire::LogRecord& record) {
  if (record.channel.ends_with("/EVENT")) {
    strobe_msgs::event_t event{};
    if (!messages::decode_checked(event, record.bytes.data(), record.bytes.size())) return std::nullopt;
    return JournalEntry{Message::Kind::event, {event.sequence, event.sequence}, event.shot_id};
  }
  strobe_msgs::shot_t shot{};
  if (!record.channel.ends_with("/SHOT") ||
      !messages::decode_checked(shot, record.bytes.data(), record.bytes.size()))
    return std::nullopt;
  return JournalEntry{Message::Kind::shot, {shot.first_sequence, shot.last_sequence}, shot.shot_id};
}

std::string boot_in_hex(std::int64_t boot_id) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(boot_id));
  return text;
}

std::filesystem::path journal_path(const std::filesystem::path& dir, std::int64_t boot_id) {
  return dir / ("journal-" + boot_in_hex(boot_id) + ".lcmlog");
}

Result<Journal> Journal::create(const std::filesystem::path& dir, std::int64_t boot_id) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) return fail(dir.string() + ": the session folder cannot be made: " + error.message());
  std::filesystem::path path = journal_path(dir, boot_id);
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (fd < 0) return fail(path.string() + ": the journal cannot be made: " + std::strerror(errno));
  flock(fd, LOCK_EX | LOCK_NB);  // where the file system knows no locks nobody can ask for one either
  Journal journal(path, fd, boot_id);
  [[maybe_unused]] const auto listed = journal.list_start();  // else make_room() tries again, and tells
  config::sync_folder(dir);  // the file's name, too, is to survive the machine
  return journal;
}

Journal::Journal(Journal&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(other.fd_),
      boot_id_(other.boot_id_),
      listed_(other.listed_),
      size_(other.size_),
      reserved_(other.reserved_),
      count_(other.count_),
      broken_(std::move(other.broken_)) {
  other.fd_ = -1;
}

Journal::~Journal() {
  if (fd_ < 0) return;
  struct stat file {};
  // Gives back the room that was set aside.
  if (fstat(fd_, &file) == 0 && file.st_size == size_ && reserved_ > size_) {
    if (ftruncate(fd_, size_) != 0) reserved_ = 0;
  }
  close(fd_);
}

Result<void> Journal::append(const std::vector<Message>& messages, std::int64_t wall_us) {
  if (messages.empty()) return {};
  std::vector<std::uint8_t> bytes;
  std::int64_t count = count_;
  for (const Message& message : messages)
    wire::append_log_record(bytes, count++, wall_us, message.channel, message.bytes);
  if (!config::write_all(fd_, {reinterpret_cast<const char*>(bytes.data()), bytes.size()})) {
    const std::string cause = std::strerror(errno);
    reserved_ = size_;
    if (ftruncate(fd_, size_) != 0 || lseek(fd_, size_, SEEK_SET) != size_) {
      return fail(path_.string() + ": " + cause + ", and the half-written end could not be cut off");
    }
    return fail(path_.string() + ": " + cause);
  }
  size_ += static_cast<std::int64_t>(bytes.size());
  count_ = count;
  assert(lseek(fd_, 0, SEEK_CUR) == size_);
  return {};
}

Result<void> Journal::sync() {
  if (fdatasync(fd_) == 0) return {};
  broken_ = path_.string() + ": " + std::strerror(errno) +
            ", and what was written may be lost; check the disk and restart strobed";
  return fail(broken_);
}

Result<void> Journal::check() const {
  if (!broken_.empty()) return fail(broken_);
  const auto failed = [this](const std::string& what) { return fail(path_.string() + ": " + what); };
  struct stat ours {
  }, there{};
  if (fstat(fd_, &ours) != 0) return failed(std::strerror(errno));
  if (ours.st_nlink == 0) return failed("the journal was removed; restart strobed");
  if (stat(path_.c_str(), &there) != 0) {
    return failed(std::string("the journal was moved away (") + std::strerror(errno) +
                  "); put it back or restart strobed");
  }
  if (ours.st_dev != there.st_dev || ours.st_ino != there.st_ino)
    return failed("another file is in the journal's place; restart strobed");
  if (ours.st_size != size_) return failed("the journal was changed by another program; restart strobed");
  struct statvfs system {};
  if (fstatvfs(fd_, &system) == 0 && (system.f_flag & ST_RDONLY) != 0)
    return failed("the file system is read-only");
  const std::string dir = path_.parent_path().string();
  if (faccessat(AT_FDCWD, dir.empty() ? "." : dir.c_str(), W_OK | X_OK, AT_EACCESS) != 0)
    return failed(std::string("the folder cannot be written: ") + std::strerror(errno));
  return {};
}

Result<void> Journal::list_start() {
  if (listed_) return {};
  auto done = StartOrder::add(path_.parent_path(), boot_id_);
  listed_ = done.has_value();
  return done;
}

Result<void> Journal::make_room() {
  if (auto listed = list_start(); !listed) return listed;
  // Room for the next shot is asked for while there still is that of a whole one.
  constexpr std::int64_t kAhead = 2 * kShotRoom;
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < static_cast<rlim_t>(size_ + kShotRoom))
    return fail(path_.string() + ": no room for another shot: " + std::strerror(EFBIG));
  if (reserved_ - size_ >= kShotRoom) return {};
  if (fallocate(fd_, FALLOC_FL_KEEP_SIZE, size_, kAhead) == 0) {
    reserved_ = size_ + kAhead;
    return {};
  }
  if (errno == EOPNOTSUPP || errno == ENOSYS || errno == EINTR) return free_room();
  return fail(path_.string() + ": no room for another shot: " + std::strerror(errno));
}

/// Where none can be set aside.
Result<void> Journal::free_room() const {
  struct statvfs system {};
  if (fstatvfs(fd_, &system) != 0) return {};
  const auto wanted = static_cast<std::uintmax_t>(kShotRoom);
  if (std::uintmax_t{system.f_bavail} * system.f_frsize >= wanted) return {};
  return fail(path_.string() + ": no room for another shot: " + std::strerror(ENOSPC));
}

bool DamageCheck::step() {
  const wire::LogReader::Step step = log_.advance(record_);
  if (step == wire::LogReader::Step::record) {
    damaged_ += record_.offset - whole_end_;
    whole_end_ = log_.at();
  }
  return step != wire::LogReader::Step::end;
}

std::string DamageCheck::finding() const {
  if (damaged_ == 0) return "";
  return "boot " + boot_in_hex(boot_id_) + ": " + std::to_string(damaged_) +
         " bytes in the middle of its journal are damaged";
}

}  // namespace strobe::firmware
