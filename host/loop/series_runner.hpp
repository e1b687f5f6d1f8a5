// Fires a series on a host loop: steps the series, sends its commands, and in the end has the events fetched
// that were lost on the way. step() is to be called after each turn of the loop. Single-threaded; never
// waits.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/loop/host_loop.hpp"
#include "host/loop/resumption.hpp"
#include "host/session/session_folder.hpp"
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
  int counted_before() const { return resumption_ ? resumption_->former().counted() : 0; }

  void step();
  /// Ends the series before its time: the shot under way is aborted, the rig disarmed, whoever armed it,
  /// until that is confirmed, for ten seconds at most; then lost events are recovered. Returns false if it
  /// had ended already. by: who asks, for a person.
  bool stop(const std::string& by);
  /// As stop(), whatever is under way, and lost events are not waited for.
  void stop_at_once(const std::string& by);
  /// Waits for nothing any more.
  void leave();
  /// No shot after the one under way, if one is.
  void end_after_shot(const std::string& why);
  /// The shots that count are enough: the series has succeeded.
  void settle() { series_.settle(); }

  bool finished() const { return phase_ == Phase::finished; }
  /// The series has been fired or given up; lost events are being fetched, or have been.
  bool fired() const { return phase_ == Phase::recovering || phase_ == Phase::finished; }
  bool firing() const { return phase_ == Phase::firing; }
  bool taking_in() const { return phase_ == Phase::taking_in; }
  /// How long lost events have been fetched; 0 before.
  Duration recovering_for() const;
  const ShotSeries& series() const { return series_; }

  void on_shot_result(const Shot& result) override;
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
  std::optional<Resumption> resumption_;
  std::optional<GapRecovery> recovery_;
};

// A series fired on the host loop, with all that is heard kept in a session folder. Before a shot is followed
// by the next, what was heard of it is on the disk; when the disk fails, or a photograph cannot be kept, the
// shot under way is the last one. Ports as the loop's; single-threaded.

class StoredSeries final : private HostListener {
 public:
  /// The references must outlive the object. What earlier runs in the folder left is taken in first.
  StoredSeries(const HostLoopSettings& settings, const ShotSeriesSettings& series, SessionFolder& folder,
               Transport& transport, Clock& clock);

  /// Why it is not known what earlier runs left: then nothing may be fired. Absent: it is known.
  const std::optional<Error>& former_error() const { return former_error_; }

  HostLoop& loop() { return loop_; }
  SeriesRunner& runner() { return runner_; }

  /// Waits for messages, takes them in, stores them, goes on with the series. Returns false if nothing can be
  /// received any more.
  bool run_once();
  /// The parts of run_once() after the messages.
  void step();
  /// No more messages: the rest is stored, the files are closed.
  void close();

  /// In place of close() after an exception: disarms and stores what it can.
  void abandon() noexcept;

  /// What is not stored, a line each; empty: all is.
  std::vector<std::string> unstored() const;

 private:
  void on_shot_result(const Shot& result) override;
  void on_shot(const strobe_msgs::shot_t& shot) override;
  void on_camera(const tether::OpenedEvent& camera) override;
  void on_not_kept(const std::string& what) override;
  void tell_failures();

  SessionFolder& folder_;
  Clock& clock_;
  LoggedTransport transport_;
  HostLoop loop_;
  SeriesRunner runner_;
  std::optional<Error> former_error_;
  bool unsynced_ = false;  ///< there is a new result
  HostTime tended_;
  std::vector<std::string> not_kept_;
};

}  // namespace strobe::host
