// The host that fires a series, as `strobe fire` does, on a virtual clock: the shipped shot series, session
// and decoder between a bus and nothing. One object for each life of the process. One thread's; allocates.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/loop/session_monitor.hpp"
#include "host/messages/message_decoder.hpp"
#include "host/session/gap_recovery.hpp"
#include "host/session/shot_series.hpp"

namespace strobe::soak {

struct HostSettings {
  std::string rig;
  host::AssemblySettings assembly;
  host::ShotSeriesSettings series;
};

/// The session folder's log of a host, of which events are known when another host starts there.
using HostLog = std::vector<std::pair<std::int64_t, std::int64_t>>;  ///< boot, sequence

class VirtualHost {
 public:
  using Send = std::function<void(const strobe_msgs::command_t&)>;
  using Done = std::function<void(const host::ShotResult&)>;

  /// now_ns: of the host's own steady clock.
  VirtualHost(const HostSettings& settings, std::int64_t host_id, HostLog& log, Send send, Done done,
              std::int64_t now_ns);

  void receive(const std::string& channel, const std::vector<std::uint8_t>& bytes, std::int64_t now_ns);
  /// What is due: every 20 ms at the latest, and after messages.
  void turn(std::int64_t now_ns);

  /// The series is over, and what was lost on the way has been fetched or given up.
  bool ended() const { return ended_; }
  bool firing() const { return !series_.finished(); }
  const host::ShotSeries& run() const { return series_; }
  std::int64_t id() const { return factory_.host_id(); }
  /// Text of an exception thrown on a message; empty if none.
  const std::string& fault() const { return decoder_.fault(); }
  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }

 private:
  void collect(std::int64_t now_ns);

  const HostSettings& settings_;
  HostLog& log_;
  Send send_;
  host::CommandFactory factory_;
  host::ShotSeries series_;
  host::SessionMonitor monitor_;
  host::MessageDecoder decoder_;
  std::int64_t started_ns_;
  std::optional<host::GapRecovery> recovery_;
  bool ended_ = false;
  std::vector<std::string> notifications_;
};

}  // namespace strobe::soak
