#include "firmware/publisher/journal_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>

#include "firmware/publisher/journal.hpp"
#include "firmware/publisher/shot_numbers.hpp"

namespace strobe::firmware {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBefore = "journal-", kAfter = ".lcmlog";

/// The file of a journal, locked against other daemons. Readable only if there are no rights to write.
class LockedFile {
 public:
  explicit LockedFile(const fs::path& path) : fd_(open(path.c_str(), O_RDWR | O_CLOEXEC)) {
    in_use_ = fd_ >= 0 && flock(fd_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  }
  LockedFile(const LockedFile&) = delete;
  LockedFile& operator=(const LockedFile&) = delete;
  ~LockedFile() {
    if (fd_ >= 0) close(fd_);
  }
  bool in_use() const { return in_use_; }
  /// Empty: done.
  std::string cut(std::int64_t size) {
    if (fd_ < 0) return "it cannot be written";
    if (ftruncate(fd_, size) != 0 || fsync(fd_) != 0) return std::strerror(errno);
    return "";
  }
  /// The room that a dead daemon had set aside for the next shot.
  void give_back_room(std::int64_t size) {
    struct stat file {};
    if (fd_ < 0 || fstat(fd_, &file) != 0 || file.st_blocks * 512 < size + Journal::kShotRoom / 2) return;
    if (ftruncate(fd_, size) != 0) return;  // a pity, no more
  }
  /// A repair makes no journal newer than it is.
  void set_written(const timespec& when) {
    const timespec times[2] = {{0, UTIME_OMIT}, when};
    if (fd_ >= 0) futimens(fd_, times);  // without it the order of starts may be wrong, no more
  }

 private:
  int fd_;
  bool in_use_ = false;
};

struct Contents {
  std::int64_t boot_id = 0;
  std::int64_t last_sequence = 0;
  std::int32_t last_shot_id = 0;
  std::int32_t open_shot = 0;  ///< started, without a summary; 0: none
  std::int32_t closed_shot = 0;
  std::int64_t begin = 0;      ///< read from here to the end
  std::int64_t whole_end = 0;  ///< where the last whole record ends
  std::int64_t damaged = 0;    ///< bytes between whole records
  bool any = false;
};

struct JournalFile {
  fs::path path;
  std::int64_t boot_id = 0;
  std::size_t position = 0;  ///< in the order of starts
  timespec written{};        ///< last, by the file system
};

std::optional<std::int64_t> boot_of(const std::string& name) {
  if (name.size() != kBefore.size() + 16 + kAfter.size() || !name.starts_with(kBefore) ||
      !name.ends_with(kAfter))
    return std::nullopt;
  std::uint64_t value = 0;
  const char* digits = name.data() + kBefore.size();
  const auto [end, error] = std::from_chars(digits, digits + 16, value, 16);
  if (error != std::errc() || end != digits + 16) return std::nullopt;
  return static_cast<std::int64_t>(value);
}

void enter(const JournalEntry& entry, Contents& contents) {
  contents.last_shot_id = std::max(contents.last_shot_id, entry.shot_id);
  if (entry.kind == Message::Kind::shot) {
    contents.closed_shot = entry.shot_id;
    if (contents.open_shot == entry.shot_id) contents.open_shot = 0;
    return;
  }
  contents.last_sequence = std::max(contents.last_sequence, entry.sequences.last);
  if (entry.shot_id > contents.closed_shot) contents.open_shot = entry.shot_id;
}

Contents contents_from(const JournalFile& file, std::int64_t begin) {
  Contents contents;
  contents.boot_id = file.boot_id;
  contents.begin = contents.whole_end = begin;
  wire::LogReader log(file.path);
  log.seek(begin);
  for (wire::LogRecord record; log.next(record);) {
    const auto entry = entry_of(record);
    if (!contents.any && begin > 0) {
      // The reading began anywhere: what looks like a record may be a part of one.
      if (!entry) {
        log.seek(record.offset + 1);
        continue;
      }
      contents.whole_end = record.offset;
    }
    contents.any = true;
    contents.damaged += record.offset - contents.whole_end;
    contents.whole_end = log.at();
    if (entry) enter(*entry, contents);
  }
  return contents;
}

constexpr std::int64_t kEnd_bytes = std::int64_t{64} << 10;
constexpr std::int64_t kLongestEnd_bytes = std::int64_t{16} << 20;

/// A journal's end: as much of it as has an event and, if that is wanted, a shot's number, within the limit.
Contents end_of(const JournalFile& file, bool find_shot) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file.path, error);
  const std::int64_t bytes = error ? 0 : static_cast<std::int64_t>(size);
  for (std::int64_t end = kEnd_bytes;; end *= 16) {
    Contents contents = contents_from(file, std::max<std::int64_t>(bytes - end, 0));
    const bool found = contents.last_sequence > 0 && (contents.last_shot_id > 0 || !find_shot);
    if (found || contents.begin == 0 || end >= kLongestEnd_bytes) return contents;
  }
}

/// What begins in a journal's torn end, in words: "an EVENT", "zeros" ...
std::string tail_in_words(const fs::path& path, std::int64_t from) {
  std::array<char, wire::kLogHeaderSize + 64> bytes{};
  std::ifstream file(path, std::ios::binary);
  file.seekg(from);
  file.read(bytes.data(), bytes.size());
  const std::string_view begin(bytes.data(), static_cast<std::size_t>(file.gcount()));
  if (begin.find_first_not_of('\0') == std::string_view::npos) return "zeros";
  if (!begin.starts_with(wire::kLogSync_bytes.substr(0, begin.size()))) return "no record";
  for (const std::string_view kind : {"/EVENT", "/SHOT"}) {
    if (begin.find(kind) != std::string_view::npos) return std::string("a torn ").append(kind.substr(1));
  }
  return "a torn record";
}

std::string boot(const Contents& contents) {
  return std::string("boot ").append(boot_in_hex(contents.boot_id)).append(": ");
}

/// Cuts off what follows the last whole record.
void mend(const fs::path& path, LockedFile& file, const Contents& contents,
          std::vector<std::string>& repaired) {
  std::error_code error;
  const auto size = static_cast<std::int64_t>(fs::file_size(path, error));
  if (error) return;
  if (size <= contents.whole_end) return file.give_back_room(size);
  const std::string tail = tail_in_words(path, contents.whole_end);
  const std::string what = boot(contents) + std::to_string(size - contents.whole_end) + " bytes (" + tail +
                           ") after event " + std::to_string(contents.last_sequence);
  if (!contents.any && (tail == "no record" || contents.begin > 0)) {
    repaired.push_back(path.filename().string() +
                       (contents.begin > 0 ? " has no record in its last 16 MiB" : " is no journal") +
                       ", and is left as it is");
    return;
  }
  const std::string fault = file.cut(contents.whole_end);
  repaired.push_back(fault.empty() ? what + " were cut off" : what + " cannot be cut off: " + fault);
}

void name_losses(const Contents& last, std::vector<std::string>& repaired) {
  if (last.begin == 0 && last.damaged > 0) {
    repaired.push_back(boot(last) + std::to_string(last.damaged) +
                       " bytes in the middle of its journal are damaged");
  }
  if (last.open_shot != 0) {
    repaired.push_back(boot(last) + "shot " + std::to_string(last.open_shot) +
                       " has no end; what came after event " + std::to_string(last.last_sequence) +
                       " is lost");
  }
}

std::vector<JournalFile> newest_first(const fs::path& dir) {
  std::vector<JournalFile> files;
  const StartOrder order(dir);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir, error)) {
    const auto boot_id = boot_of(entry.path().filename().string());
    struct stat file {};
    if (boot_id && stat(entry.path().c_str(), &file) == 0)
      files.push_back({entry.path(), *boot_id, order.position(*boot_id), file.st_mtim});
  }
  const auto when = [](const JournalFile& file) {
    return std::tuple(file.position, file.written.tv_sec, file.written.tv_nsec);
  };
  std::ranges::sort(files, std::ranges::greater(), when);
  return files;
}

/// Nullopt: another daemon is writing it, or it has no event.
std::optional<Contents> repair(const JournalFile& journal, bool find_shot, FolderFindings& findings) {
  LockedFile file(journal.path);
  Contents contents = end_of(journal, find_shot);
  findings.last_shot_id = std::max(findings.last_shot_id, contents.last_shot_id);
  if (file.in_use()) return std::nullopt;
  mend(journal.path, file, contents, findings.repaired);
  file.set_written(journal.written);
  if (contents.last_sequence == 0) return std::nullopt;
  return contents;
}

}  // namespace

FolderFindings repair_journals(const fs::path& dir) {
  FolderFindings findings;
  std::vector<Contents> boots;
  const bool find_shots = !ShotNumbers::read(dir);
  std::size_t seen = 0;
  for (const JournalFile& journal : newest_first(dir)) {
    if (++seen > FolderFindings::kLatest) {
      if (!find_shots) break;
      findings.last_shot_id = std::max(findings.last_shot_id, end_of(journal, true).last_shot_id);
    } else if (const auto contents = repair(journal, find_shots, findings)) {
      boots.push_back(*contents);
    }
  }
  for (const Contents& boot : boots) findings.earlier.push_back({boot.boot_id, boot.last_sequence});
  if (boots.empty()) return findings;
  // Of the last one only: what earlier ones lost was reported then.
  name_losses(boots.front(), findings.repaired);
  if (boots.front().begin > 0) findings.unchecked_boot = boots.front().boot_id;
  return findings;
}

namespace {

constexpr const char* kFile = "starts";
constexpr std::int64_t kTail_bytes = std::int64_t{64} << 10;

}  // namespace

StartOrder::StartOrder(const std::filesystem::path& dir) {
  std::ifstream file(dir / kFile, std::ios::binary | std::ios::ate);
  if (!file) return;
  file.seekg(std::max<std::int64_t>(file.tellg() - kTail_bytes, 0));
  for (std::string line; std::getline(file, line);) {
    std::uint64_t boot_id = 0;
    const char* const end = line.data() + line.size();
    const auto [after, error] = std::from_chars(line.data(), end, boot_id, 16);
    if (line.size() == 16 && error == std::errc() && after == end)
      positions_[static_cast<std::int64_t>(boot_id)] = positions_.size() + 1;
  }
}

std::size_t StartOrder::position(std::int64_t boot_id) const {
  const auto found = positions_.find(boot_id);
  return found == positions_.end() ? 0 : found->second;
}

Result<void> StartOrder::add(const std::filesystem::path& dir, std::int64_t boot_id) {
  const std::filesystem::path path = dir / kFile;
  const auto failed = [&path] {
    return fail(path.string() + ": this start cannot be listed: " + std::strerror(errno));
  };
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (fd < 0) return failed();
  const std::string line = "\n" + boot_in_hex(boot_id);  // so that what was torn is a line of its own
  errno = ENOSPC;                                        // of a write that was cut short
  const bool done = write(fd, line.data(), line.size()) == std::ssize(line) && fsync(fd) == 0;
  const int cause = errno;
  close(fd);
  errno = cause;
  if (!done) return failed();
  return {};
}

}  // namespace strobe::firmware
