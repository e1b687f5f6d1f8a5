// Checks the virtual lab's invariants from outside: lines, key and e-stop, packets as delivered, the journals
// on the disk. Uses no state of the product. The invariants:
//  - a pulse of the machine's trigger only with the key on, the e-stop released, and a FIRE of this boot's
//    firmware that carries a fresh token of an ARM of the same host; each token for one pulse;
//  - after the key goes off or the e-stop is pressed every output is inactive within 1 ms, and none stays
//    or becomes active until both are good again (the trigger: within 2 us);
//  - after a stop that reached the rig (key or e-stop moved either way, a DISARM, its machine's sleep) the trigger only
//    by a FIRE of a host at which a person acted after it, and no sooner than 2 s after a RESET; as much after a stop
//    that a host showed as confirmed; after the sleep of a host's machine by no FIRE sent later without an act;
//  - a stop asked for at a host that is not shown as confirmed within a second is shown as a danger by then;
//  - no output longer than its limit, lamps no closer and no more often than theirs;
//  - in the end all outputs are inactive, every event in a journal is on the host (but of a boot that ended
//    before any host received a message: such events are counted), sequences have no gaps;
//  - one readout for one shot of one host; no wrong number without a flag that explains it.
// Time during which the machine is stopped is not counted. After a process's end its
// guardian has 6 ms.
// One thread's; allocates.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/reduction/readout.hpp"
#include "common/shot/shot_key.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/output_lines.hpp"
#include "tests/soak/counts.hpp"

namespace strobe::soak {

class InvariantChecker {
 public:
  using EventKey = std::pair<std::int64_t, std::int64_t>;  ///< boot, sequence

  explicit InvariantChecker(const firmware::Rig& limits) : limits_(limits) {}

  // The rig
  void output(firmware::Output output, bool active, MonoTime at, strobe::Lamps lamps = strobe::Lamps::both);
  void key(bool on, MonoTime at);
  void estop(bool pressed, MonoTime at);

  // The processes
  void booted(std::int64_t boot_id, MonoTime at = {});
  void died(MonoTime at) { died_ = at, alive_ = false; }
  void stands_still(MonoTime from, MonoTime until) { still_.push_back({from, until}); }
  void token_drawn(std::int64_t token, MonoTime at);

  // The persons and what they are shown; times of one host by its own clock
  void acted(std::int64_t host_id, MonoTime at) { acted_[host_id] = at; }
  void suspended(MonoTime at) { ++stops_.reached, stop(at); }
  /// wakes: when that host's machine goes on.
  void host_sleeps(std::int64_t host_id, MonoTime wakes) { host_slept_[host_id] = wakes; }
  void stop_asked(std::int64_t host_id, HostTime then, MonoTime at);
  void confirmation_shown(std::int64_t host_id);
  /// What a host shows now, as long as it lives.
  void shows(std::int64_t host_id, bool danger, HostTime now);
  void host_gone(std::int64_t host_id) { asked_.erase(host_id); }

  // The packets
  void at_firmware(const std::vector<std::uint8_t>& command, MonoTime at);
  void at_host(const std::string& channel, const std::vector<std::uint8_t>& bytes);

  // The results
  void readout(std::int64_t host_id, ShotKey shot, const reduction::Readout& readout, const Truth& truth,
               bool dry);
  /// At the end: compares the folder's journals with what the hosts have.
  void end(const std::filesystem::path& session);

  const std::vector<std::string>& violations() const { return violations_; }
  const std::optional<TruthComparison>& last_comparison() const { return comparison_; }
  int triggers() const { return triggers_; }
  struct Stops {
    int reached = 0;       ///< the rig; a switch moved there and back counts once
    int asked = 0;         ///< at a host
    int confirmed = 0;     ///< of these, as their host showed
    int danger_shown = 0;  ///< of these, not confirmed within a second, and told so
    int triggers = 0;      ///< pulses between a stop and the next act of a person
  };
  const Stops& stops() const { return stops_; }
  std::int64_t events_journalled() const { return journalled_; }
  std::int64_t events_missing() const { return missing_; }
  /// Of boots that ended before any host received a message of theirs.
  std::int64_t events_never_received() const { return never_received_; }

  /// Records a violation.
  void violate(std::string what) { violations_.push_back(std::move(what)); }

 private:
  struct Token {
    std::int64_t host_id = 0, boot_id = 0;
    MonoTime armed, fired = kNoTime;
    bool dry = false, spent = false;
  };
  struct Still {
    MonoTime from, until;
  };
  struct Watched {
    bool active = false;
    MonoTime since;
    MonoTime must_end = kNoTime;  ///< made unsafe at that instant, while active
  };

  struct Asked {
    HostTime then;
    MonoTime at;
    bool reached = false, danger = false;
  };

  bool armed_in_another_boot(std::int64_t host_id) const;
  void check_trigger(MonoTime at);
  std::string objection_to(const Token& token, MonoTime at) const;
  void stop(MonoTime at);
  void note_command(std::int64_t host_id, std::int8_t kind, MonoTime at);
  void check_lamps(strobe::Lamps lamps, MonoTime at);
  void check_end(firmware::Output output, const Watched& watched, MonoTime at);
  void became_unsafe(MonoTime at);
  Duration excused(MonoTime from, MonoTime to) const;
  Duration longest(firmware::Output output) const;
  bool unsafe_before(MonoTime at) const;
  void read_journal(const std::filesystem::path& path);

  firmware::Rig limits_;
  std::array<Watched, firmware::kOutputs.size()> outputs_{};
  bool key_ = true, estop_ = false, alive_ = true;
  MonoTime booted_at_{};
  MonoTime unsafe_since_ = kNoTime, died_ = kNoTime;
  std::vector<Still> still_;
  std::int64_t boot_id_ = 0, arming_host_ = 0;
  MonoTime last_stop_ = kNoTime,
           reset_ = kNoTime;  ///< the first RESET since that stop, of a person's act after it
  bool stopped_in_boot_ = false;
  std::map<std::int64_t, MonoTime> acted_, host_slept_;  ///< by host
  std::map<std::int64_t, std::int64_t> newest_command_;  ///< likewise
  std::map<std::int64_t, Asked> asked_;                  ///< likewise; not confirmed
  Stops stops_;
  std::map<std::int64_t, Token> tokens_;
  std::array<MonoTime, 2> last_flash_{kNoTime, kNoTime};  ///< of lamp A, of lamp B
  int flashes_of_shot_ = 0, triggers_ = 0;
  std::map<std::int64_t, std::vector<bool>> on_host_;  ///< of each boot, by sequence
  std::set<std::pair<std::int64_t, ShotKey>> read_out_;
  std::optional<TruthComparison> comparison_;
  std::int64_t journalled_ = 0, missing_ = 0, never_received_ = 0;
  std::vector<std::string> violations_;
};

}  // namespace strobe::soak
