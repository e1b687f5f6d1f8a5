// Tells the page what happens on a host's loop. The loop's thread's alone; never waits; a turn costs it
// microseconds.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/loop/host_loop.hpp"
#include "host/view/render.hpp"
#include "host/web/live_channel.hpp"

namespace strobe::web {

/// What the loop's owner knows besides.
struct Progress {
  int counted = 0;            ///< shots that count towards `wanted`
  std::optional<int> wanted;  ///< absent: no series is being fired
  bool can_stop = false;
};

class LiveFeed final : public host::HostListener {
 public:
  /// Shots and notifications that wait for room; more are left out, with a notification that says so.
  static constexpr std::size_t kMaxWaiting = 256;

  /// Both must outlive the feed. Add it to the loop's listeners, after those that a viewer must not be told
  /// before.
  LiveFeed(LiveChannel& channel, host::Clock& clock) : channel_(channel), clock_(clock) {}

  /// From now on only results of these hosts' shots are told.
  void show_only(std::function<bool(std::int64_t host_id)> shown) { shown_ = std::move(shown); }

  void on_shot_result(const host::Shot& result) override;
  void on_notification(const std::string& text) override;

  /// After each turn of the loop: tells how things are, at once where something has changed that a person
  /// waits for, else twice a second. model: up to date.
  void step(host::HostLoop& loop, const host::ViewModel& model, const Progress& progress);

  std::vector<LiveCommand> take_commands() { return channel_.take_commands(); }

 private:
  void add(LiveMessage message);
  std::string now_utc();
  LiveStatus status_of(host::HostLoop& loop, const host::ViewModel& model, const Progress& progress);

  LiveChannel& channel_;
  host::Clock& clock_;
  std::function<bool(std::int64_t)> shown_;
  std::deque<LiveMessage> waiting_;
  bool left_out_ = false;
  std::shared_ptr<const strobe_msgs::status_t> heard_;  ///< the newest status, copied once
  HostTime heard_at_;
  LiveStatus published_;
  bool told_any_ = false;
  HostTime told_at_;
};

}  // namespace strobe::web
