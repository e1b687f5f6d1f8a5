// Firing a series: arm, fire, wait for the readout, fire rejected shots again, until all have come or the
// retries are used up. It acts only on what answers it: on shots of the boot that gave this host the token,
// with this host's id, later than the token; on refusals later than the command. So a log that is played
// back, whose seals are good, ends no shot.
//
// It begins by a person's act, which resets a stop from before. A stop that comes then (key, e-stop, DISARM,
// a fault, a firmware that was started anew) ends it with the shot under way: what returns later starts
// nothing. A state machine on messages and the host's clock; no I/O; single-threaded.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/status_t.hpp>
#include <tuple>
#include <utility>
#include <vector>

#include "host/messages/command_factory.hpp"
#include "host/session/session.hpp"

namespace strobe::host {

struct ShotSeriesSettings {
  int shots = 1;               ///< that are to count, `counted` included
  bool at_most = false;        ///< fewer may be enough: settle()
  int counted = 0;             ///< so many do already
  bool whole_session = false;  ///< shots of earlier runs whose result comes now count, too
  int retries = 0;             ///< further shots that may be fired for rejected ones, in all
  ShotPlan plan;
  reduction::Record notes;
  double blocked_timeout_s =
      60.0;  ///< gives up if nothing can be fired (no firmware, key off ...) for so long
  /// Of a photograph after its shot. Where one has not come, the next shot waits for as long again: a
  /// photograph that comes while no other was exposed cannot be taken for another shot's.
  double photograph_timeout_s = 5.0;
  bool clear_fault = false;
};

class ShotSeries {
 public:
  ShotSeries(ShotSeriesSettings settings, CommandFactory& factory)
      : settings_(std::move(settings)), factory_(factory), good_(settings_.counted) {}

  void on_event(const strobe_msgs::event_t& event);
  /// The result of a shot; those of other hosts are ignored.
  void on_shot_result(const Shot& shot_result);
  /// The result of a shot that an earlier run fired.
  void on_former_result(const Shot& shot_result);
  /// What to do now. status: the newest; absent if the firmware is silent (Session::live_status()).
  void step(const std::optional<strobe_msgs::status_t>& status, HostTime now);
  /// Ends the series with the shot under way; if there is none, at once. why: for a person.
  void end_after_shot(const std::string& why);
  /// The shots that count are enough: with the last one's result the series has succeeded.
  void settle() { settings_.shots = good_; }
  /// Ends the series; what is armed or under way is for the caller to disarm.
  void stop() { state_ = State::finished; }

  /// Who holds the arming that the status tells of, if it is known; whether it was an earlier run of one's
  /// own.
  void on_arming_of(std::string host_name, bool own);
  /// Another rig has the name (LiveBoots): nothing is armed. Empty: none has.
  void on_second_rig(std::string why) { second_rig_ = std::move(why); }
  /// The camera is away, or spoils its photographs: nothing is armed or fired until it is ready. Empty: it
  /// is. stamped: what comes late cannot be taken for the next shot's photograph, which need not wait.
  void on_camera(std::string problem, bool stamped) {
    camera_problem_ = std::move(problem);
    stamped_ = stamped;
  }
  /// The rig is heard and does not answer (AnswerWatch): why nothing comes of an ARM. Empty: not so.
  void on_unanswered(std::string why) { unanswered_ = std::move(why); }
  /// Outputs may be active (Session::danger()): nothing more is fired. Empty: nothing is known of it.
  void on_danger(const std::string& danger);

  std::vector<strobe_msgs::command_t> take_commands() { return std::exchange(commands_, {}); }
  /// Once: what is armed is not wanted any more.
  bool take_disarm() { return std::exchange(disarm_, false); }
  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }

  bool finished() const { return state_ == State::finished; }
  /// Whether a shot has been asked for and has no result yet.
  bool shot_under_way() const { return state_ == State::firing || state_ == State::shooting; }
  /// The number that the shot under way has, as far as nobody else fires.
  int shot_number() const { return shots_before_ + 1; }
  bool succeeded() const { return good_ >= settings_.shots; }
  int good() const { return good_; }
  int refired() const { return refired_; }
  /// "arming", "shot fired, waiting for the photograph" ...
  std::string activity() const;
  /// Why nothing can be fired, for a person; empty if it can.
  const std::string& blocking_reason() const { return blocking_reason_; }
  /// What its next steps depend on, besides its settings and what words say.
  auto progress() const {
    return std::tuple(state_, entered_, sent_, begun_boot_, admitted_, boot_id_, shots_before_, fired_,
                      asked_boot_, good_, refired_, refusals_, !refusal_.empty(), !ending_.empty());
  }

 private:
  enum class State { waiting, arming, firing, shooting, finished };

  void begin(const strobe_msgs::status_t& status, HostTime now);
  void check_stop(const strobe_msgs::status_t& status);
  void on_stop_event(const strobe_msgs::event_t& event);
  void wait_for_readiness(const strobe_msgs::status_t& status, HostTime now);
  void arm(const strobe_msgs::status_t& status, HostTime now);
  void fire(const strobe_msgs::status_t& status, HostTime now);
  void shoot(const strobe_msgs::status_t& status, HostTime now);
  void enter(State state, HostTime now);
  void on_rejected(const std::string& why, std::int64_t shot_id);
  void give_up(const std::string& why);
  void send_arm(const strobe_msgs::status_t& status, HostTime now);
  void send_fire(const strobe_msgs::status_t& status, HostTime now);
  void sent(const strobe_msgs::status_t& status, HostTime now);
  double longest_shot_s() const;
  bool ours(const strobe_msgs::status_t& status) const;
  /// Beside what the rig's status says; empty: nothing.
  const std::string& obstacle() const { return second_rig_.empty() ? camera_problem_ : second_rig_; }
  std::string why_blocked(const strobe_msgs::status_t& status);
  std::string who_armed(const strobe_msgs::status_t& status);

  ShotSeriesSettings settings_;
  CommandFactory& factory_;
  State state_ = State::waiting;
  HostTime entered_;
  HostTime sent_;
  std::optional<HostTime> blocked_since_;
  HostTime began_;                ///< its first step
  std::int64_t begun_boot_ = 0;   ///< the firmware that the series began with; 0: it has not begun
  std::int64_t begun_after_ = 0;  ///< its newest event then
  bool admitted_ = false;         ///< it has given a token
  bool disarm_ = false;
  std::int64_t boot_id_ = 0;       ///< firmware of the shot that is under way
  std::int32_t shots_before_ = 0;  ///< its last_shot_id before the shot
  bool fired_ = false;             ///< FIRE was sent, and the shot has no result yet
  std::int64_t asked_boot_ = 0;    ///< whom the newest command went to
  std::int64_t asked_after_ = 0;   ///< its newest event then
  HostTime now_;
  int good_ = 0;
  int refired_ = 0;
  int refusals_ = 0;
  HostTime quiet_until_;     ///< no shot before: a photograph may still come
  std::string arming_host_;  ///< who holds the arming; empty: not known
  bool own_arming_ = false;
  std::optional<std::pair<std::int64_t, std::string>> left_of_arming_;  ///< of the token, in words
  bool stamped_ = false;
  std::string second_rig_, camera_problem_, unanswered_;
  std::string blocking_reason_;
  std::string refusal_;
  std::string ending_;  ///< why there is no further shot; empty: there may be
  std::vector<strobe_msgs::command_t> commands_;
  std::vector<std::string> notifications_;
};

}  // namespace strobe::host
