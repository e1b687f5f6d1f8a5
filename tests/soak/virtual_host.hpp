// The host that fires a series, as `strobe fire` is, or one that watches, as `strobe live` is: the shipped host loop on
// the soak's bus and virtual clock.
// One object for each life of the process. Single-threaded; allocates.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/loop/series_runner.hpp"
#include "tests/soak/bus.hpp"

namespace strobe::soak {

struct HostSettings {
  std::string rig;
  host::AssemblySettings assembly;
  std::optional<host::ShotSeriesSettings> series;  ///< absent: it only watches
};

/// The session folder's log of a host, of which events are known when another host starts there.
using HostLog = std::vector<std::pair<std::int64_t, std::int64_t>>;  ///< boot, sequence

class VirtualHost final : host::Transport, host::Clock, host::HostListener {
 public:
  using Send = std::function<void(Bytes sealed_command)>;
  using Done = std::function<void(const host::Shot&)>;

  VirtualHost(const HostSettings& settings, std::int64_t host_id, const authentication::Key& key,
              HostLog& log, Send send, Done done, const host::HostReading& now);

  void receive(const std::string& channel, Bytes bytes, const host::HostReading& now);
  /// What is due: every 20 ms at the latest, and after messages.
  void step(const host::HostReading& now);

  /// As `strobe fire` heeds Ctrl-C: the shot under way first. Returns whether the rig is to be disarmed.
  bool interrupt();
  /// As it heeds Ctrl-\.
  void stop_at_once() { runner_->stop_at_once("the operator"); }
  void disarm(const std::string& by) { loop_.disarm(by); }
  /// A DISARM has been asked for and is not confirmed.
  bool disarming() const { return loop_.disarming(); }
  /// What a person is warned of; empty: of nothing.
  const std::string& danger() const { return loop_.session().danger(); }

  /// The series is over, and what was lost on the way has been fetched or given up.
  bool ended() const { return runner_->finished(); }
  bool firing() const { return !runner_->series().finished(); }
  const host::ShotSeries& series() const { return runner_->series(); }
  std::int64_t id() const { return loop_.settings().host_id; }
  /// What an exception on a message said; empty: there was none.
  const std::string& fault() const { return loop_.fault(); }
  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }

 private:
  // Ports of the loop
  bool receive(std::chrono::milliseconds, std::span<const int>, const Receiver&) override { return true; }
  void publish(const std::string& channel, Bytes bytes) override;
  host::HostReading read() override { return now_; }

  void on_shot_result(const host::Shot& result) override { done_(result); }
  void on_event(const strobe_msgs::event_t& event) override;
  void on_notification(const std::string& text) override { notifications_.push_back(text); }

  HostLog& log_;
  Send send_;
  Done done_;
  host::HostReading now_;
  std::string command_channel_;
  host::HostLoop loop_;
  std::optional<host::SeriesRunner> runner_;
  std::vector<std::string> notifications_;
};

/// A host's machine in the virtual lab: its clocks, its session folder's log, and the host that runs on it. One thread's.
struct HostMachine {
  HostMachine(Receiver as, Random& random)
      : receiver(as),
        rate(1.0 + random.uniform(-50e-6, 50e-6)),
        origin(from_ns<HostTime>(std::llround(random.uniform(1e9, 1e15)))) {}

  /// world: the time that passes for all, on whatever machine.
  host::HostReading read(MonoTime world) const {
    const HostTime since_boot = origin + Duration{std::llround(static_cast<double>(to_ns(world)) * rate)};
    return {since_boot - slept, WallTime{since_boot.time_since_epoch()}, since_boot.time_since_epoch()};
  }

  Receiver receiver;
  double rate;
  HostTime origin;
  std::unique_ptr<VirtualHost> process;  ///< null: none runs
  HostLog log;
  MonoTime due = kFarFuture;  ///< its next step
  MonoTime wakes;             ///< the machine sleeps until then
  Duration slept{};
};

}  // namespace strobe::soak
