// Fires a series on a host loop: steps the series, sends its commands, and in the end has the events fetched
// that were lost on the way. step() is to be called after each turn of the loop. Single-threaded; never waits.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "host/loop/host_loop.hpp"
#include "host/loop/take_in.hpp"
#include "host/session/gap_recovery.hpp"
#include "host/session/shot_series.hpp"

namespace strobe::host {

class SeriesRunner final : public HostListener {
 public:
  /// Adds itself to the loop's listeners; the loop must be the longer-lived and have a key.
  SeriesRunner(HostLoop& loop, ShotSeriesSettings settings);

  /// Before the series: what earlier runs left.
  void take_in_first(FormerRuns former);

  /// Called once, before the series begins.
  void set_on_begin(std::function<void()> on_begin) { on_begin_ = std::move(on_begin); }
  /// Shots in the folder that count, of earlier runs.
  int counted_before() const { return take_in_ ? take_in_->former().counted() : 0; }

  void step();
  /// Ends the series before its time: the shot under way is aborted, the rig disarmed, whoever armed it, until that is
  /// confirmed, for ten seconds at most; then lost events are recovered. Returns false if it had ended already. by: who
  /// asks, for a person.
  bool stop(const std::string& by);
  /// As stop(), whatever is under way, and lost events are not waited for.
  void stop_at_once(const std::string& by);
  /// Waits for nothing any more.
  void leave();
  /// No shot after the one under way, if one is.
  void end_after_shot(const std::string& why);

  bool finished() const { return phase_ == Phase::finished; }
  /// The series has been fired or given up; lost events are being fetched, or have been.
  bool fired() const { return phase_ == Phase::recovering || phase_ == Phase::finished; }
  bool firing() const { return phase_ == Phase::firing; }
  bool taking_in() const { return phase_ == Phase::taking_in; }
  /// How long lost events have been fetched; 0 before.
  Duration recovering_for() const;
  const ShotSeries& series() const { return series_; }

  void on_shot_result(const ShotResult& result) override;
  void on_event(const strobe_msgs::event_t& event) override { series_.on_event(event); }

 private:
  enum class Phase { taking_in, firing, disarming, recovering, finished };

  void enter(Phase phase);
  void fire();
  void send_commands();

  HostLoop& loop_;
  ShotSeries series_;
  Phase phase_ = Phase::firing;
  HostTime entered_;
  std::function<void()> on_begin_;
  bool hurried_ = false;  ///< lost events are not waited for
  std::optional<TakeIn> take_in_;
  std::optional<GapRecovery> recovery_;
};

}  // namespace strobe::host
