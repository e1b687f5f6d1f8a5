// Command messages of this host: one host id per process, command ids that rise; put under seal for one rig.
// No I/O; single-threaded.
#pragma once

#include <cstdint>
#include <string>
#include <strobe_msgs/command_t.hpp>
#include <utility>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "common/shot/shot_plan.hpp"

namespace strobe::host {

class CommandFactory {
 public:
  /// host_id: random, not 0. host_name: who arms, for other hosts; empty: nothing is said.
  explicit CommandFactory(std::int64_t host_id, std::string host_name = "")
      : host_id_(host_id), host_name_(std::move(host_name)) {}

  std::int64_t host_id() const { return host_id_; }
  const std::string& host_name() const { return host_name_; }
  strobe_msgs::command_t arm(std::int64_t boot_id);
  strobe_msgs::command_t fire(std::int64_t boot_id, std::int64_t arm_token, const ShotPlan& plan,
                              const reduction::Record& notes);
  strobe_msgs::command_t disarm(std::int64_t boot_id);
  strobe_msgs::command_t clear(std::int64_t boot_id);
  /// When the person acted is for the host loop to fill in.
  strobe_msgs::command_t reset(std::int64_t boot_id);
  /// boot_id: of the firmware that is asked, which may hold the journal of the range's earlier boot.
  strobe_msgs::command_t resend(std::int64_t boot_id, const EventRange& range);

 private:
  strobe_msgs::command_t make(std::int64_t boot_id, std::int8_t kind);
  strobe_msgs::command_t named(strobe_msgs::command_t command) const;

  std::int64_t host_id_;
  std::string host_name_;
  std::int64_t next_id_ = 1;
};

/// Seals one rig's commands with the lab's key.
class CommandSealer {
 public:
  CommandSealer(const authentication::Key& key, std::string rig) : key_(key), rig_(std::move(rig)) {}
  /// The encoded sealed_command_t. Fails if the command's notes and plan are too large for one.
  Result<std::vector<std::uint8_t>> seal(const strobe_msgs::command_t& command) const;

 private:
  authentication::Key key_;
  std::string rig_;
};

}  // namespace strobe::host
