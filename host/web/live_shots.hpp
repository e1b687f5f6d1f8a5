// The newest shots of the session that this process writes, so that a viewer sees them without its logs being
// read again. The listener's part is the loop's thread's, which copies a shot and a result under a short
// lock; the rest is any thread's.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "host/archive/read_session.hpp"
#include "host/loop/host_loop.hpp"

namespace strobe::web {

class LiveShots final : public host::HostListener {
 public:
  /// rig: as the run uses it, never null. own: whether a host's shots are the session's.
  LiveShots(std::filesystem::path folder, std::shared_ptr<const host::RigFile> rig,
            std::function<bool(std::int64_t host_id)> own)
      : folder_(std::move(folder)), rig_(std::move(rig)), own_(std::move(own)) {}

  void on_shot_result(const host::Shot& shot) override;

  const std::filesystem::path& folder() const { return folder_; }
  /// As a reading of the folder would have it, but for name and time, which are the caller's. Absent: not
  /// among the newest.
  std::optional<host::Shot> find(const ShotKey& key) const;
  /// The newest of the number, where no row tells the shot's start.
  std::optional<ShotKey> newest_numbered(int shot_id) const;

  static constexpr std::size_t kMaxKept = 32;

 private:
  std::filesystem::path folder_;
  std::shared_ptr<const host::RigFile> rig_;
  std::function<bool(std::int64_t)> own_;
  mutable std::mutex mutex_;
  std::deque<host::Shot> newest_;  ///< oldest first
};

}  // namespace strobe::web
