// Server-sent events (WHATWG HTML, 9.2): the newest ones are kept once for all viewers, each of whom reads on
// from where he is. Who is too slow, or comes back too late, is told to fetch everything anew (`reset`):
// nobody waits for him. Thread-safe; publish() holds a lock for the time of a move.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace strobe::web {

class EventHub {
 public:
  /// first_id: larger than any id of an earlier server that a viewer may still name; see first_event_id().
  explicit EventHub(std::int64_t first_id = 1) : next_id_(first_id), oldest_(first_id) {}

  /// event: a word. json: one line.
  void publish(std::string_view event, std::string json);
  /// Of the newest event; below the first id: there was none.
  std::int64_t last_id() const;

  struct Taken {
    std::string text;          ///< of the stream; empty: nothing is new
    std::int64_t last_id = 0;  ///< the viewer has all up to here
  };
  /// What comes after the event `seen`, as many whole events as fit max_bytes, one at least. Where those
  /// after `seen` are not kept any more, or it is no id of this hub's: one `reset`, and the newest id.
  Taken take_after(std::int64_t seen, std::size_t max_bytes) const;

  /// Called after each event, on the publisher's thread, without the lock; must not wait. Empty: none.
  void set_wake(std::function<void()> wake);

  static constexpr std::size_t kMaxKept = 512;
  static constexpr std::size_t kMaxKept_bytes = 2 * 1024 * 1024;

 private:
  mutable std::mutex mutex_;
  std::int64_t next_id_;
  std::int64_t oldest_;  ///< id of the first one kept
  std::deque<std::string> kept_;
  std::size_t kept_bytes_ = 0;
  std::mutex wake_mutex_;
  std::function<void()> wake_;
};

/// From the wall clock: larger than any id of a server that ended before, unless the clock was set back.
std::int64_t first_event_id();

}  // namespace strobe::web
