// The host that fires a series, as `strobe fire` is, on a virtual clock: the shipped campaign, session and
// intake between a bus and nothing. One object for each life of the process. One thread's; allocates.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/session/campaign.hpp"
#include "host/session/collection.hpp"
#include "host/session/follower.hpp"
#include "host/session/intake.hpp"

namespace strobe::soak {

struct HostOrder {
  std::string rig;
  host::AssemblySettings assembly;
  host::CampaignSettings campaign;
};

/// The session folder's log of a host, of which events are known when another host starts there.
using HostLog = std::vector<std::pair<std::int64_t, std::int64_t>>;  ///< boot, sequence

class VirtualHost {
 public:
  using Send = std::function<void(const strobe_msgs::command_t&)>;
  using Done = std::function<void(const host::Outcome&)>;

  /// now_ns: of the host's own steady clock.
  VirtualHost(const HostOrder& order, std::int64_t host_id, HostLog& log, Send send, Done done,
              std::int64_t now_ns);

  void receive(const std::string& channel, const std::vector<std::uint8_t>& bytes, std::int64_t now_ns);
  /// What is due: every 20 ms at the latest, and after messages.
  void turn(std::int64_t now_ns);

  /// The series is over, and what was lost on the way has been fetched or given up.
  bool ended() const { return ended_; }
  bool firing() const { return !campaign_.finished(); }
  const host::Campaign& campaign() const { return campaign_; }
  std::int64_t id() const { return maker_.host_id(); }
  /// What an exception on a message said; empty: there was none.
  const std::string& fault() const { return intake_.fault(); }
  std::vector<std::string> take_notices() { return std::exchange(notices_, {}); }

 private:
  void collect(std::int64_t now_ns);

  const HostOrder& order_;
  HostLog& log_;
  Send send_;
  host::CommandMaker maker_;
  host::Campaign campaign_;
  host::Follower follower_;
  host::Intake intake_;
  std::int64_t started_ns_;
  std::optional<host::Collection> collection_;
  bool ended_ = false;
  std::vector<std::string> notices_;
};

}  // namespace strobe::soak
