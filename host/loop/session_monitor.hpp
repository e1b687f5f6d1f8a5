// Follows a session for a person: shot_results as they come, the series, what there is to say. Shared by fire,
// live and replay. No I/O; single-threaded.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/messages/message_decoder.hpp"
#include "host/session/session.hpp"
#include "host/view/render.hpp"

namespace strobe::host {

class SessionMonitor : public MessageHandler {
 public:
  /// As Session has it.
  SessionMonitor(AssemblySettings settings, std::int64_t firing_host_id, bool from_start, std::string title)
      : session_(std::move(settings), firing_host_id, from_start) {
    model_.title = std::move(title);
  }
  SessionMonitor(AssemblySettings settings, std::int64_t firing_host_id, std::string title)
      : SessionMonitor(std::move(settings), firing_host_id, firing_host_id != 0, std::move(title)) {}

  void status(const strobe_msgs::status_t& message, std::int64_t now_ns) override;
  void event(const strobe_msgs::event_t& message, std::int64_t now_ns) override;
  void shot(const strobe_msgs::shot_t& message, std::int64_t now_ns) override;
  void frame(const strobe_msgs::frame_t& message, std::int64_t now_ns) override;
  void time(std::int64_t now_ns);
  /// This machine's clocks, now and then: notifications that its wall clock was set, or that it was suspended.
  void local_clocks(const ClockReading& clocks);
  void end();

  /// Called for each shot that is done, after it has entered the series.
  std::function<void(const ShotResult&)> on_shot_result;
  /// Called for each new event, after the session has it.
  std::function<void(const strobe_msgs::event_t&)> on_event;
  /// Called for each shot's summary, as often as it comes.
  std::function<void(const strobe_msgs::shot_t&)> on_shot;
  /// Called for each line that a person should read.
  std::function<void(const std::string&)> on_notification;

  void notify(const std::string& text);
  /// Absent if none was heard within two seconds.
  std::optional<strobe_msgs::status_t> heard(std::int64_t now_ns) const;

  Session& session() { return session_; }
  Model& model() { return model_; }
  /// The model, brought up to date.
  const Model& shown(std::int64_t now_ns);
  int shot_results() const { return shot_results_; }

 private:
  void hand_on();

  Session session_;
  Model model_;
  int shot_results_ = 0;
};

}  // namespace strobe::host
