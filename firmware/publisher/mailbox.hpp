// From the receiver to the publisher: what does not concern the loop. Not real-time (a mutex); any thread.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "firmware/publisher/messages.hpp"
#include "firmware/publisher/resend.hpp"

namespace strobe::firmware {

/// The notes that came with a FIRE, kept until its shot is over.
struct ShotNotes {
  std::int64_t host_id = 0;
  std::int64_t command_id = 0;
  std::vector<Note> notes;
};

class Mailbox {
 public:
  void ask(const ResendRequest& request) {
    const std::lock_guard lock(mutex_);
    resends_.add(request);
  }
  /// What is to be sent again next; whatever was before it has been sent.
  std::optional<EventRange> next_resend() {
    const std::lock_guard lock(mutex_);
    return resends_.next();
  }
  bool resends_wait() const {
    const std::lock_guard lock(mutex_);
    return !resends_.empty();
  }
  void keep(ShotNotes notes) {
    const std::lock_guard lock(mutex_);
    if (notes_.size() == kMaxNotes) notes_.erase(notes_.begin());  // of commands that were refused
    notes_.push_back(std::move(notes));
  }
  std::vector<Note> take(std::int64_t host_id, std::int64_t command_id) {
    const std::lock_guard lock(mutex_);
    for (auto it = notes_.begin(); it != notes_.end(); ++it) {
      if (it->host_id != host_id || it->command_id != command_id) continue;
      std::vector<Note> notes = std::move(it->notes);
      notes_.erase(it);
      return notes;
    }
    return {};
  }

 private:
  static constexpr std::size_t kMaxNotes = 64;
  mutable std::mutex mutex_;
  ResendQueue resends_;
  std::vector<ShotNotes> notes_;
};

}  // namespace strobe::firmware
