// Which photograph shows which shot. A photograph comes after its exposure has ended, its file is not older
// than the opening of the shutter, and photographs come in the order of the exposures. What these leave open
// is waited for, and in the end left unmatched: a shot without a photograph is fired again, one with the
// wrong photograph is a wrong number. No I/O; deterministic; single-threaded.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <strobe_msgs/shot_t.hpp>
#include <utility>
#include <vector>

#include "common/shot/shot_key.hpp"
#include "host/clock/device_clock.hpp"

namespace strobe::host {

/// What became of a photograph.
struct PhotographDecision {
  int photograph = 0;
  std::optional<ShotKey> shot;  ///< absent: of no shot
  bool wanted = false;          ///< the shot needs it measured
  bool late = false;            ///< the shot has been given up
  std::string why;              ///< for a person, if it is of no shot
};

/// Instants: `local` ones on the caller's steady clock, `device` ones on the firmware's, in nanoseconds.
class PhotographMatcher {
 public:
  /// `clock` relates the firmware's clock to the host's; it must outlive the matcher.
  PhotographMatcher(const DeviceClock& clock, double timeout_s)
      : clock_(clock), timeout_ns_(static_cast<std::int64_t>(timeout_s * 1e9)) {}

  /// A shot whose shutter has opened; dry ones have photographs, too. Known shots change nothing.
  void on_shot(const strobe_msgs::shot_t& shot);
  /// The photograph of this shot has been measured, here or elsewhere.
  void on_measured(const ShotKey& shot);
  /// The photograph assigned to this shot could not be read: another one may come.
  void give_back(const ShotKey& shot);
  /// A photograph has arrived; numbers rise.
  void on_photograph(int photograph, std::int64_t arrived_local_ns, std::int64_t written_local_ns);

  /// What can be decided by now.
  std::vector<PhotographDecision> decide(std::int64_t local_ns);
  /// Nothing more will come: the rest is of no shot.
  std::vector<PhotographDecision> end(std::int64_t local_ns);

 private:
  struct Exposure {
    ShotKey key;
    std::int64_t opened_ns = 0;  ///< device
    std::int64_t closed_ns = 0;
    bool wanted = false;
    bool taken = false;
  };
  struct Held {
    int photograph = 0;
    std::int64_t arrived_ns = 0;
    std::int64_t written_ns = 0;
  };
  struct Candidates {
    std::vector<std::size_t> waiting;   ///< within the time for photographs
    std::vector<std::size_t> given_up;  ///< past it
    std::size_t count() const { return waiting.size() + given_up.size(); }
  };

  std::int64_t local(std::int64_t device_ns) const { return clock_.local_ns(device_ns).value_or(device_ns); }
  Candidates candidates(const Held& held, std::int64_t now_ns) const;
  std::optional<PhotographDecision> decide_first(std::int64_t now_ns);
  std::optional<PhotographDecision> choose(const Candidates& candidates, std::int64_t now_ns);
  PhotographDecision take(std::size_t exposure, std::int64_t now_ns, bool certain);
  PhotographDecision reject(std::string why);
  std::string nobody(const Held& held) const;
  std::int64_t own_due_ns(const Exposure& exposure) const;

  const DeviceClock& clock_;
  std::int64_t timeout_ns_;
  std::optional<std::int64_t> usual_ns_;  ///< longest from closing to arrival so far
  std::vector<Exposure> exposures_;       ///< in order of their closing
  std::vector<Held> held_;                ///< in order of arrival
};

}  // namespace strobe::host
