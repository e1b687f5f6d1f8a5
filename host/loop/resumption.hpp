#pragma once

#include <cstdint>
#include <optional>

#include "host/loop/host_loop.hpp"
#include "host/session/former_runs.hpp"
#include "host/session/session.hpp"

namespace strobe::host {

/// The end of a series: events that were lost on the way are fetched from strobed's journal before the host's
/// log is closed. No I/O.
class GapRecovery {
 public:
  explicit GapRecovery(HostTime now) : started_(now) {}

  /// Whether no event is missing, by a status that was sent after the start, or none more is to be had: the
  /// firmware is silent and nothing was missing, nothing new has come for 15 s (networks are cut for ten), or
  /// a minute is over. To be called at least every second.
  bool finished(const Session& session, HostTime now);

 private:
  HostTime started_;
  HostTime progress_;  ///< when something new came last
  std::int64_t received_ = 0;
};

/// --resume: what former runs left unfinished is measured and read out before the first new shot.
class Resumption final : public HostListener {
 public:
  /// Enters what the logs tell, and adds itself to the loop's listeners; the loop must be the longer-lived.
  Resumption(HostLoop& loop, FormerRuns former);

  const FormerRuns& former() const { return former_; }
  /// To be called after each turn of the loop. Returns true once there is nothing left to wait for.
  bool finished();

  void on_shot(const strobe_msgs::shot_t& shot) override;
  void on_shot_result(const Shot& result) override;

 private:
  enum class Phase { fetching, measuring, finishing, finished };

  void begin();
  void enter(Phase phase);
  bool fetched();
  void measure_photographs();
  LeftShots left_shots() const;
  DeviceClock clock_of_logs(const std::set<ShotKey>& wanted) const;

  HostLoop& loop_;
  FormerRuns former_;
  Phase phase_ = Phase::fetching;
  HostTime entered_;
  bool begun_ = false;
  std::optional<GapRecovery> recovery_;
};

}  // namespace strobe::host
