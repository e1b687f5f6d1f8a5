// A rig, two hosts and the messages between them, of which every next step is decided from outside. The shipped
// classes decide: Interlock, ShotSeries, DisarmRequest. What is left out only makes more possible (README.md).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "firmware/core/interlock.hpp"
#include "host/loop/host_loop.hpp"
#include "host/session/shot_series.hpp"

namespace strobe::stops {

inline constexpr std::int64_t kHostA = 11, kHostB = 22;

enum class Step : std::uint8_t {
  a_commands,       ///< A's operator gives the command to fire
  a_presses,        ///< A's operator presses Ctrl-backslash
  a_turns,          ///< A's series goes on, on the newest status that it has heard, which may be old
  a_waits,          ///< likewise, after all of its times but the longest
  a_hears_nothing,  ///< likewise, after the longest
  a_hears_status,
  a_hears_refusal,  ///< of whichever of its commands
  a_hears_stop,     ///< the event of one
  a_result_good,
  a_result_bad,
  a_repeats_disarm,
  a_hears_disarmed,  ///< the newest event that answers a DISARM of A's
  reset_of_a_comes,
  arm_of_a_comes,
  fire_of_a_comes,
  disarm_of_a_comes,
  disarm_of_a_lost,
  b_acts,  ///< B's operator asks to fire
  reset_of_b_comes,
  arm_of_b_comes,
  fire_of_b_comes,
  disarm_of_b_comes,
  key_off,
  key_on,
  estop_on,
  estop_off,
  sleeps,
  arming_ends,  ///< expired
  fault,
  clear_comes,
  firmware_restarts,
  trigger_due,
  shot_over,
  count
};
const char* words(Step step);

/// What is wrong on purpose.
struct Fault {
  const firmware::TransitionTable* table = &firmware::kTransitionTable;
  bool deaf_series = false;      ///< no status tells the series of a stop
  bool act_as_sent = false;      ///< RESET tells when it was sent, not when the person acted
  bool disarm_once = false;      ///< is not repeated
  bool disarm_believed = false;  ///< counts as confirmed once it was sent
};

struct Limits {
  int shots = 2, retries = 1;
  bool restarts = false;  ///< of the firmware
  bool faults = false;    ///< of the firmware
  /// What is left open (README.md) counts as wrong.
  bool strict_restart = false;
  bool ways_back = true;  ///< every state is tried for one (Model::revive)
};

/// What a host hears.
struct Snapshot {
  std::int64_t boot = 0;  ///< 0: nothing yet
  firmware::State state = firmware::State::idle;
  bool key = false, estop = false, fault = false, stop = false;
  std::int64_t arm_host = 0, arm_token = 0;
  std::int32_t last_shot = 0;
};

/// All that future steps depend on, and nothing else: times and numbers only as far as they are compared.
using Key = std::array<std::uint8_t, 48>;

class Model {
 public:
  Model(const Limits& limits, const Fault& fault);

  bool possible(Step step) const;
  /// Returns what is wrong about it; empty: nothing.
  std::string take(Step step);
  Key key() const;
  /// From here on, with good switches and all messages delivered: what is open gets confirmed, and after one more stop
  /// one act of a person leads to a trigger. Returns what does not; turns: the host's, until the trigger.
  std::string revive(int& turns) const;
  bool triggered() const { return triggered_; }  ///< by the last step
  firmware::State state() const { return lock_.state(); }

 private:
  struct Sent {
    MonoTime acted{};  ///< of RESET; 0: none
    bool arm = false;
    std::int64_t disarm = 0;  ///< the command's id; 0: none
    std::int64_t token = 0;   ///< of FIRE; 0: none
  };
  MonoTime later() { return now_ = now_ + microseconds(1); }
  void stopped(MonoTime when) { last_stop_ = when; }
  Snapshot snapshot() const;
  strobe_msgs::status_t heard() const;
  void command();
  void press();
  void step_series(Duration later);
  void hear_disarmed();
  void result(bool good);
  void event(std::int8_t kind);
  void restart();
  std::string trigger();
  void take_of_a(Step step);
  void take_at_firmware(Step step);

  Limits limits_;
  Fault fault_;
  firmware::Interlock lock_;
  std::int64_t boot_ = 1, next_token_ = 1, fired_by_ = 0;
  MonoTime now_ = from_ns(1'000'000'000);
  // Host A
  std::optional<host::ShotSeries> series_;
  host::DisarmRequest disarm_;
  std::int64_t disarms_ = 0;       ///< ids used
  std::int64_t first_disarm_ = 0;  ///< that may be confirmed; 0: none was sent since it was pressed
  std::int64_t disarmed_ = 0, disarmed_boot_ = 0;  ///< what the firmware said last; 0: nothing
  bool disarm_was_sent_ = false;
  HostTime host_now_{std::chrono::seconds{1000}};
  Snapshot heard_;
  Sent sent_;
  // What persons did, for the judge
  MonoTime act_a_{}, act_b_{}, last_stop_{};
  MonoTime pressed_{};      ///< A's newest DISARM
  bool confirmed_ = false;  ///< to A
  bool b_goes_on_ = false;  ///< B was asked to fire since the firmware started
  bool triggered_ = false;
};

}  // namespace strobe::stops
