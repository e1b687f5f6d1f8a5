// Who writes a session, or a record of commissioning: one run at a time. The lock is on a file beside what is
// written, which nobody else can open, and which tells whose run it is. It goes with its holder, however that
// ends; nothing here waits. Writes a file; one thread's.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "common/result.hpp"
#include "common/units/time.hpp"

namespace strobe::host {

class RunLock {
 public:
  /// Of a session's folder, which is made if need be.
  static Result<RunLock> of_session(const std::filesystem::path& folder, const std::string& who,
                                    WallTime now) {
    return take(folder / "session.lock", who, now);
  }
  /// who: "login@machine". Fails at once, with one line that names the file: it is held, and by whom and
  /// since when; or it cannot be opened, as where another user's run was killed. A file that others can open,
  /// as one copied from elsewhere, is replaced. Where the file system has no locks it is taken without.
  static Result<RunLock> take(const std::filesystem::path& file, const std::string& who, WallTime now);

  RunLock(RunLock&& other) noexcept
      : file_(std::move(other.file_)),
        fd_(std::exchange(other.fd_, -1)),
        held_(std::exchange(other.held_, false)),
        made_folder_(std::exchange(other.made_folder_, false)) {}
  RunLock& operator=(RunLock&&) = delete;
  /// Removes the file, and a folder that was made for it alone.
  ~RunLock();

 private:
  RunLock(std::filesystem::path file, int fd, bool made_folder)
      : file_(std::move(file)), fd_(fd), made_folder_(made_folder) {}
  Result<bool> lock();
  bool named() const;
  std::string holder() const;
  Result<void> tell(const std::string& who, WallTime now);

  std::filesystem::path file_;
  int fd_ = -1;
  bool held_ = false, made_folder_ = false;
};

}  // namespace strobe::host
