#include "host/session/run_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "common/config/files.hpp"
#include "host/session/session_folder.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kForOthers = 077;

tl::unexpected<Error> no_lock(const fs::path& file, const std::string& what) {
  return fail(fmt::format("{}: {}: {}", file.string(), what, std::strerror(errno)));
}

/// The file's descriptor, or -1.
int open_own(const fs::path& file) {
  constexpr int kFlags = O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  const int made = ::open(file.c_str(), kFlags | O_CREAT | O_EXCL, 0600);
  return made >= 0 || errno != EEXIST ? made : ::open(file.c_str(), kFlags);
}

/// A stranger who can open it can hold its lock for ever. File systems without modes show every file as open
/// to all.
bool open_to_strangers(int fd) {
  struct stat before {
  }, after{};
  if (::fstat(fd, &before) != 0 || (before.st_mode & kForOthers) == 0) return false;
  return ::fchmod(fd, 0600) == 0 && ::fstat(fd, &after) == 0 && (after.st_mode & kForOthers) == 0;
}

}  // namespace

Result<RunLock> RunLock::take(const fs::path& file, const std::string& who, WallTime now) {
  constexpr int kTries = 3;  // a run that ends meanwhile takes its file along
  std::error_code error;
  const bool made = !file.parent_path().empty() && fs::create_directories(file.parent_path(), error);
  if (error) return fail(file.parent_path().string() + ": " + error.message());
  for (int i = 0; i < kTries; ++i) {
    RunLock taken(file, open_own(file), made);
    if (taken.fd_ < 0) return no_lock(file, "cannot be opened (is it another user's?)");
    if (open_to_strangers(taken.fd_)) {
      if (::unlink(file.c_str()) != 0) return no_lock(file, "is open to others, and cannot be removed");
      continue;
    }
    const auto free = taken.lock();
    if (!free) return tl::unexpected(free.error());
    if (!*free) return fail(fmt::format("{}: in use by {}", file.string(), taken.holder()));
    if (!taken.named()) continue;
    taken.held_ = true;
    if (auto told = taken.tell(who, now); !told) return tl::unexpected(told.error());
    return taken;
  }
  return fail(file.string() + ": in use by other runs, one after the other");
}

RunLock::~RunLock() {
  if (held_ && named()) ::unlink(file_.c_str());
  if (fd_ >= 0) ::close(fd_);
  if (made_folder_) ::rmdir(file_.parent_path().c_str());  // only if nothing is in it
}

/// False: another run has it.
Result<bool> RunLock::lock() {
  int failed = 0;
  do failed = ::flock(fd_, LOCK_EX | LOCK_NB);
  while (failed != 0 && errno == EINTR);
  if (failed == 0 || errno == ENOLCK || errno == ENOSYS || errno == EOPNOTSUPP) return true;
  if (errno == EWOULDBLOCK) return false;
  return no_lock(file_, "cannot be locked");
}

/// Whether it still is the file of this name.
bool RunLock::named() const {
  struct stat here {
  }, there{};
  return ::fstat(fd_, &here) == 0 && ::lstat(file_.c_str(), &there) == 0 && here.st_ino == there.st_ino &&
         here.st_dev == there.st_dev;
}

std::string RunLock::holder() const {
  std::array<char, 200> text{};
  const ssize_t size = ::pread(fd_, text.data(), text.size(), 0);
  std::string words(text.data(), static_cast<std::size_t>(std::max<ssize_t>(0, size)));
  std::erase_if(words, [](unsigned char c) { return c < ' ' || c > '~'; });
  return words.empty() ? "another run" : words;
}

Result<void> RunLock::tell(const std::string& who, WallTime now) {
  const std::string words = fmt::format("{}, process {}, since {}\n", who, ::getpid(), utc_for_table(now));
  if (::ftruncate(fd_, 0) == 0 && config::write_all(fd_, words)) return {};
  return no_lock(file_, "cannot be written");
}

}  // namespace strobe::host
