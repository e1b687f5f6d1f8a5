// A series fired on the host loop, with all that is heard kept in a session folder. Before a shot is followed by
// the next, what was heard of it is on the disk; when the disk fails, or a photograph cannot be kept, the shot
// under way is the last one. Ports as the loop's; single-threaded.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/loop/host_loop.hpp"
#include "host/loop/series_runner.hpp"
#include "host/session/logged_transport.hpp"
#include "host/session/session_folder.hpp"

namespace strobe::host {

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
  void on_shot_result(const ShotResult& result) override;
  void on_shot(const strobe_msgs::shot_t& shot) override;
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
