// Whether more than one rig of this name is heard: each FIRE would reach one of them by chance, so nothing is
// armed meanwhile. A boot counts while its heartbeats go on (its clock advances) and no other boot that is
// heard lists it as an earlier one.
//
// A log that is played back looks the same, since its seals are good. So where two boots are heard, each is
// asked to send single events of its own again, drawn from all that it has: a rig that hears this host does,
// a log does not. One that leaves four questions unanswered is told, and no rig that a FIRE could reach: it
// does not stop the shots. Until then it counts, for three seconds; afterwards it is asked now and then.
// Whoever has the lab's key and answers stops the shots, as whoever jams the network does.
//
// Deterministic in what it is given; no I/O; single-threaded. Holds eight boots at most.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/status_t.hpp>
#include <utility>
#include <vector>

#include "common/shot/shot_key.hpp"
#include "common/units/time.hpp"

namespace strobe::host {

class LiveBoots {
 public:
  /// A boot is heard that was not heard from for less than this.
  static constexpr Duration kHeard = std::chrono::seconds{3};
  /// Heartbeats come twice a second: two have had time to come from every rig.
  static constexpr Duration kListen = milliseconds{1100};

  void set_rig(std::string name) { name_ = std::move(name); }

  /// sender: its IP address, for a person; may be empty.
  void on_status(const strobe_msgs::status_t& status, std::string sender, HostTime now);
  /// Any event: it may be an answer.
  void on_event(std::int64_t boot_id, std::int64_t sequence, HostTime now);

  /// What each boot is to be asked now; none while one boot alone is heard.
  std::vector<EventRange> due(HostTime now);
  /// All that are heard, those that answer nothing included: whom a DISARM must reach. In the order of their
  /// ids.
  std::vector<std::int64_t> heard(HostTime now) const;
  bool knows(std::int64_t boot_id) const { return boots_.contains(boot_id); }
  /// Why nothing may be armed, for a person: two rigs of the name, or who else is there is not yet known.
  /// Empty: it may.
  std::string problem(HostTime now) const;
  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }

 private:
  enum class Verdict { open, rig, silent };
  struct Boot {
    strobe_msgs::status_t status;
    std::string sender;
    HostTime heard;
    std::int64_t asked = 0;  ///< the event; 0: nothing is being asked
    std::optional<HostTime> asked_at;
    std::vector<bool> answers;  ///< to the newest questions
    bool proven = false;        ///< until it leaves all of these unanswered
    bool told = false;
    Verdict verdict() const;
  };
  using Boots = std::map<std::int64_t, Boot>;

  Boot& boot_of(std::int64_t boot_id);
  bool earlier(std::int64_t boot_id, HostTime now) const;
  bool counts(const Boots::value_type& boot, HostTime now) const;
  void note(std::int64_t boot_id, Boot& boot, bool answered);
  std::vector<Boots::const_iterator> counted(HostTime now) const;
  static bool proven(const std::vector<Boots::const_iterator>& rigs);
  std::int64_t draw(const Boots::value_type& boot, HostTime now);
  void tell_of_rigs(HostTime now);
  static std::string words(std::int64_t boot_id, const Boot& boot);

  std::string name_;
  Boots boots_;
  std::optional<HostTime> began_;
  std::uint64_t drawn_ = 0;
  bool told_rigs_ = false;
  std::vector<std::string> notifications_;
};

// Whether the rig that is heard hears this host, too. What this host asks of it is answered within
// milliseconds; where heartbeats come and no answer does, commands do not reach it, DISARM included. Fed with
// the commands that are sent and with what is heard; no I/O; single-threaded.

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
