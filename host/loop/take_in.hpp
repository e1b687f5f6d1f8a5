// What earlier runs in a session's folder left, taken in before a run fires: shots that they fired and of which there is
// no result. Messages come from their logs, what these lack from strobed's journals, photographs from the camera's
// folder. Each shot gets one result, as if it were this run's. Single-threaded; never waits.
#pragma once

#include <optional>

#include "host/loop/host_loop.hpp"
#include "host/session/former_runs.hpp"
#include "host/session/gap_recovery.hpp"

namespace strobe::host {

class TakeIn final : public HostListener {
 public:
  /// Enters what the logs tell, and adds itself to the loop's listeners; the loop must be the longer-lived.
  TakeIn(HostLoop& loop, FormerRuns former);

  const FormerRuns& former() const { return former_; }
  /// To be called after each turn of the loop. Returns true once there is nothing left to wait for.
  bool finished();

  void on_shot(const strobe_msgs::shot_t& shot) override;
  void on_shot_result(const ShotResult& result) override;

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
