// What the screen said of each shot, kept as text in the session's folder: results, refusals and notes in
// their order, each with its time. Single-threaded.
#pragma once

#include <functional>
#include <string>

#include "host/clock/machine_clock.hpp"
#include "host/loop/host_loop.hpp"
#include "host/session/session_folder.hpp"

namespace strobe::host {

class ShotText final : public HostListener {
 public:
  /// Of shots of hosts that `shown` accepts. The references must outlive the object.
  ShotText(SessionFolder& folder, Clock& clock, std::function<bool(std::int64_t host_id)> shown)
      : folder_(folder), clock_(clock), shown_(std::move(shown)) {}

  /// A line of its own.
  void add(const std::string& line);
  void on_shot_result(const Shot& result) override;
  void on_notification(const std::string& text) override { add(text); }

 private:
  std::string now() const;

  SessionFolder& folder_;
  Clock& clock_;
  std::function<bool(std::int64_t)> shown_;
};

}  // namespace strobe::host
