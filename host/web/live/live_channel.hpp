// Between the host's loop and the page: the loop never waits, neither for the lock (it tries, and comes again with its
// next turn) nor for room (what does not fit is left out and told). Commands wake the loop through a descriptor.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <vector>

#include "host/web/live/live_message.hpp"

namespace strobe::web {

class LiveChannel {
 public:
  static constexpr std::size_t kMaxMessages = 1024;
  static constexpr std::size_t kMaxCommands = 16;

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
  /// False if too many wait already.
  bool command(LiveCommand command);
  /// take() returns from now on at once.
  void end();

 private:
  int event_;
  std::mutex messages_mutex_;
  std::condition_variable changed_;
  std::deque<LiveMessage> messages_;
  bool ended_ = false;
  std::mutex commands_mutex_;
  std::vector<LiveCommand> commands_;
  std::atomic<bool> has_commands_{false};
};

}  // namespace strobe::web
