// Between the host's loop and the page: what the loop tells, and what the page asks of it. The loop never
// waits, neither for the lock (it tries, and comes again with its next turn) nor for room (what does not fit
// is left out and told). Commands wake the loop through a descriptor; who gives one learns whether the loop
// has taken it. Thread-safe.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <strobe_msgs/status_t.hpp>
#include <variant>
#include <vector>

#include "common/authentication/unverified.hpp"
#include "host/clock/device_clock.hpp"
#include "host/session/shot.hpp"

namespace strobe::web {

struct LiveStatus {
  std::shared_ptr<const strobe_msgs::status_t> status;  ///< newest; null: no firmware was ever heard
  bool silent = true;                                   ///< it has not been heard for a while
  double age_s = 0.0;                                   ///< of the newest status
  std::string danger;    ///< of outputs that may be active; empty: none is known of
  std::string missing;   ///< why nothing can be fired; empty: it can
  std::string activity;  ///< what is under way; empty: nothing to say
  std::string armed_by;  ///< who holds the arming, if that is known
  host::ClockState clock;
  int shots = 0;              ///< whose results have come
  int counted = 0;            ///< of them, and of those before that the series goes on with
  std::optional<int> wanted;  ///< shots that are to count
  std::int64_t events_missing = 0;
  bool verified = true;
  authentication::UnverifiedCounts unverified;
  std::size_t photographs_pending = 0;
  bool can_stop = false, can_disarm = false;
};

struct LiveNotification {
  std::string utc, text;
};

/// A shot with the time at which its result came.
using LiveMessage = std::variant<LiveStatus, host::Shot, LiveNotification>;

struct LiveCommand {
  enum class Kind {
    stop,   ///< finish the shot under way, then end the series
    disarm  ///< now; a shot under way is aborted
  };
  Kind kind = Kind::stop;
  std::string from;  ///< the viewer's address
};

class LiveChannel {
 public:
  static constexpr std::size_t kMaxMessages = 1024;
  static constexpr std::size_t kMaxCommands = 16;
  /// A loop turns every 20 ms; one that has taken nothing for so long stands still.
  static constexpr std::chrono::milliseconds kPatience{1000};

  LiveChannel();
  ~LiveChannel();
  LiveChannel(const LiveChannel&) = delete;
  LiveChannel& operator=(const LiveChannel&) = delete;

  // For the loop's thread.
  /// Hands over what it can, in order; the rest stays.
  void put(std::deque<LiveMessage>& messages);
  /// Those that have come; at most kMaxCommands, none if the lock is held just now.
  std::vector<LiveCommand> take_commands();
  /// Readable when there are commands; -1 where the system gave none.
  int descriptor() const { return event_; }

  // For the page's threads.
  struct Taken {
    std::deque<LiveMessage> messages;
    bool ended = false;
  };
  /// Waits for messages, or the end.
  Taken take();
  enum class Given {
    taken,     ///< by the loop
    waits,     ///< the loop has taken no command for `patience`, and gets this one when it comes to it
    too_many,  ///< wait already: it is not given
  };
  /// Waits for the loop to take it, until the oldest command that it has not taken is `patience` old.
  Given command(LiveCommand command, std::chrono::milliseconds patience = kPatience);
  /// take() and command() return from now on at once.
  void end();

 private:
  int event_;
  std::mutex messages_mutex_;
  std::condition_variable changed_;
  std::deque<LiveMessage> messages_;
  bool ended_ = false;
  std::mutex commands_mutex_;
  std::condition_variable commands_taken_;
  std::vector<LiveCommand> commands_;
  std::int64_t given_ = 0, taken_ = 0;  ///< commands so far
  std::chrono::steady_clock::time_point oldest_;
  bool nobody_takes_ = false;
  std::atomic<bool> has_commands_{false};
};

}  // namespace strobe::web
