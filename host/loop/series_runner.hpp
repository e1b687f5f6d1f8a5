// Fires a series on a host loop: steps the series, sends its commands, and in the end has the events fetched
// that were lost on the way. step() is to be called after each turn of the loop. Single-threaded; never waits.
#pragma once

#include <cstdint>
#include <optional>

#include "host/loop/host_loop.hpp"
#include "host/session/gap_recovery.hpp"
#include "host/session/shot_series.hpp"

namespace strobe::host {

class SeriesRunner final : public HostListener {
 public:
  /// Adds itself to the loop's listeners; the loop must be the longer-lived and have a key.
  SeriesRunner(HostLoop& loop, ShotSeriesSettings settings);

  void step();
  /// Ends the series before its time: disarms, which may take a second, then recovers lost events. Returns
  /// false if it had ended already.
  bool stop();
  /// No shot after the one under way, if one is.
  void end_after_shot(const std::string& why);

  bool finished() const { return phase_ == Phase::finished; }
  /// The series has been fired or given up; lost events are being fetched, or have been.
  bool fired() const { return phase_ == Phase::recovering || phase_ == Phase::finished; }
  /// How long lost events have been fetched; 0 before.
  Duration recovering_for() const;
  const ShotSeries& series() const { return series_; }

  void on_shot_result(const ShotResult& result) override { series_.on_shot_result(result); }
  void on_event(const strobe_msgs::event_t& event) override { series_.on_event(event); }

 private:
  enum class Phase { firing, disarming, recovering, finished };

  void enter(Phase phase);
  void fire();
  void send_commands();
  bool disarmed() const;

  HostLoop& loop_;
  ShotSeries series_;
  Phase phase_ = Phase::firing;
  HostTime entered_;
  std::optional<GapRecovery> recovery_;
};

}  // namespace strobe::host
