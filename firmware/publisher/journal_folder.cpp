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
#include <string_view>

#include "firmware/publisher/journal.hpp"

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
  std::int64_t wall_us = 0;    ///< of the newest record
  std::int64_t whole_end = 0;  ///< where the last whole record ends
  std::int64_t damaged = 0;    ///< bytes between whole records
  bool any = false;
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

void enter(const LogRecord& record, Contents& contents) {
  JournalEntry entry;
  std::int32_t shot_id = 0;
  if (!entry_of(record, entry, shot_id)) return;
  contents.last_shot_id = std::max(contents.last_shot_id, shot_id);
  if (entry.kind == Message::Kind::shot) {
    contents.closed_shot = shot_id;
    if (contents.open_shot == shot_id) contents.open_shot = 0;
    return;
  }
  contents.last_sequence = std::max(contents.last_sequence, entry.sequences.last);
  if (shot_id > contents.closed_shot) contents.open_shot = shot_id;
}

Contents contents_of(const fs::path& path, std::int64_t boot_id) {
  Contents contents;
  contents.boot_id = boot_id;
  LogReader log(path);
  for (LogRecord record; log.next(record);) {
    contents.any = true;
    contents.wall_us = record.wall_us;
    contents.damaged += record.offset - contents.whole_end;
    contents.whole_end = log.at();
    enter(record, contents);
  }
  return contents;
}

/// What begins in a journal's torn end, in words: "an EVENT", "zeros" ...
std::string tail_in_words(const fs::path& path, std::int64_t from) {
  std::array<char, kLogHeaderSize + 64> bytes{};
  std::ifstream file(path, std::ios::binary);
  file.seekg(from);
  file.read(bytes.data(), bytes.size());
  const std::string_view begin(bytes.data(), static_cast<std::size_t>(file.gcount()));
  if (begin.find_first_not_of('\0') == std::string_view::npos) return "zeros";
  if (!begin.starts_with(std::string_view("\xED\xA1\xDA\x01", std::min<std::size_t>(4, begin.size()))))
    return "no record";
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
  if (!contents.any && tail == "no record") {
    repaired.push_back(path.filename().string() + " is no journal, and is left as it is");
    return;
  }
  const std::string fault = file.cut(contents.whole_end);
  repaired.push_back(fault.empty() ? what + " were cut off" : what + " cannot be cut off: " + fault);
}

void name_losses(const Contents& last, std::vector<std::string>& repaired) {
  if (last.damaged > 0) {
    repaired.push_back(boot(last) + std::to_string(last.damaged) +
                       " bytes in the middle of its journal are damaged");
  }
  if (last.open_shot != 0) {
    repaired.push_back(boot(last) + "shot " + std::to_string(last.open_shot) +
                       " has no end; what came after event " + std::to_string(last.last_sequence) +
                       " is lost");
  }
}

}  // namespace

FolderFindings repair_journals(const fs::path& dir) {
  FolderFindings findings;
  std::vector<Contents> boots;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir, error)) {
    const auto boot_id = boot_of(entry.path().filename().string());
    if (!boot_id) continue;
    LockedFile file(entry.path());
    Contents contents = contents_of(entry.path(), *boot_id);
    findings.last_shot_id = std::max(findings.last_shot_id, contents.last_shot_id);
    if (file.in_use()) continue;
    mend(entry.path(), file, contents, findings.repaired);
    if (contents.last_sequence > 0) boots.push_back(contents);
  }
  std::sort(boots.begin(), boots.end(),
            [](const Contents& a, const Contents& b) { return a.wall_us > b.wall_us; });
  for (const Contents& boot : boots) findings.earlier.push_back({boot.boot_id, boot.last_sequence});
  // Of the last one only: what earlier ones lost was reported then.
  if (!boots.empty()) name_losses(boots.front(), findings.repaired);
  return findings;
}

}  // namespace strobe::firmware
