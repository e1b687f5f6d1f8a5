// Which photograph shows which shot. A camera with a clock says when it exposed: that is within the shot's
// exposure, or of no shot. Of others a photograph comes after its exposure has ended, its file is not older
// than the opening of the shutter, and photographs come in the order of the exposures. What these leave open
// is waited for, and in the end left unmatched: a shot without a photograph is fired again, one with the
// wrong photograph is a wrong number. Shots of several boots may be waiting, each on its own boot's clock.
// No I/O; deterministic; single-threaded.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <strobe_msgs/shot_t.hpp>
#include <utility>
#include <vector>

#include "common/shot/shot_key.hpp"
#include "host/clock/device_clock.hpp"
#include "host/tether/driver_messages.hpp"

namespace strobe::host {

/// What became of a photograph.
struct PhotographDecision {
  int photograph = 0;
  std::optional<ShotKey> shot;  ///< absent: of no shot
  bool wanted = false;          ///< the shot needs it measured
  bool late = false;            ///< the shot has been given up
  std::string why;              ///< for a person, if it is of no shot
};

class PhotographMatcher {
 public:
  /// `clock` relates the firmware's clock to the host's; it must outlive the matcher.
  PhotographMatcher(const DeviceClock& clock, double timeout_s)
      : clock_(clock), timeout_(from_seconds(timeout_s)) {}

  /// A shot whose shutter has opened; dry ones have photographs, too. Known shots change nothing.
  void on_shot(const strobe_msgs::shot_t& shot);
  /// The photograph of this shot has been measured, here or elsewhere.
  void on_measured(const ShotKey& shot);
  /// The photograph of this shot has come before.
  void on_taken(const ShotKey& shot);
  /// The photograph assigned to this shot could not be read: another one may come.
  void give_back(const ShotKey& shot);
  /// A photograph has arrived, or word that one is lost; numbers rise. written: its file's time.
  void on_photograph(int photograph, HostTime arrived, HostTime written,
                     std::optional<tether::ExposureStart> exposed = std::nullopt);

  /// What can be decided by now.
  std::vector<PhotographDecision> decide(HostTime now);
  /// Nothing more will come: the rest is of no shot.
  std::vector<PhotographDecision> end(HostTime now);

 private:
  struct Exposure {
    ShotKey key;
    MonoTime opened;
    MonoTime closed;
    bool wanted = false;
    bool taken = false;
  };
  struct Held {
    int photograph = 0;
    HostTime arrived;
    HostTime written;
    std::optional<tether::ExposureStart> exposed;
  };
  struct Candidates {
    std::vector<std::size_t> waiting;   ///< within the time for photographs
    std::vector<std::size_t> given_up;  ///< past it
    std::size_t count() const { return waiting.size() + given_up.size(); }
  };

  /// On this machine's clock.
  struct Local {
    HostTime opened;
    HostTime closed;
  };

  /// Returns nullopt before the first heartbeat of its boot.
  std::optional<Local> local(const Exposure& exposure) const;
  bool closed_later(const Exposure& one, const Exposure& other) const;
  Candidates candidates(const Held& held, HostTime now) const;
  std::vector<std::size_t> exposed_within(const tether::ExposureStart& exposed) const;
  std::optional<PhotographDecision> decide_exposed(std::size_t held, HostTime now);
  std::optional<PhotographDecision> decide_first(HostTime now);
  std::optional<PhotographDecision> choose(const Candidates& candidates, HostTime now);
  PhotographDecision take(std::size_t held, std::size_t exposure, HostTime now, bool certain);
  PhotographDecision reject(std::size_t held, std::string why);
  std::string nobody(const Held& held) const;
  HostTime own_due(const Exposure& exposure) const;
  bool may_still_come(const Exposure& exposure, HostTime arrived) const;

  const DeviceClock& clock_;
  Duration timeout_;
  std::optional<Duration> usual_;    ///< longest from closing to arrival so far
  std::vector<Exposure> exposures_;  ///< in order of their closing
  std::vector<Held> held_;           ///< in order of arrival
};

}  // namespace strobe::host
