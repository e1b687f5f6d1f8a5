// Whether the rig that is heard hears this host, too. What this host asks of it is answered within milliseconds; where
// heartbeats come and no answer does, commands do not reach it, DISARM included. Fed with the commands that are sent and
// with what is heard; no I/O; single-threaded.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include "common/units/time.hpp"

namespace strobe::host {

class AnswerWatch {
 public:
  static constexpr Duration kLongest = std::chrono::seconds{2};
  /// Any one of them, or its answer, may get lost.
  static constexpr int kQuestions = 4;

  /// status: the newest; a command to another boot is no question.
  void on_sent(const strobe_msgs::command_t& command, const std::optional<strobe_msgs::status_t>& status,
               HostTime now);
  void on_status(const strobe_msgs::status_t& status);
  void on_event(const strobe_msgs::event_t& event);

  /// For a person; empty: it answers, nothing was asked for so long, or it is not heard any more.
  std::string problem(HostTime now) const;

 private:
  struct Question {
    std::int8_t kind = 0;
    std::int64_t host_id = 0;
    std::int64_t after = 0;  ///< its newest event when it was sent
    std::int64_t first = 0, last = 0;
  };
  bool answered_by(const strobe_msgs::status_t& status) const;

  std::int64_t boot_id_ = 0;
  std::optional<Question> newest_;
  HostTime since_;  ///< the first that was not answered
  int asked_ = 0;
  int heartbeats_ = 0;  ///< since then
  std::int64_t forged_before_ = 0, forged_ = 0;
};

}  // namespace strobe::host
