// Command messages of this host: one host id per process, command ids that rise. No I/O; single-threaded.
#pragma once

#include <cstdint>
#include <strobe_msgs/command_t.hpp>

#include "common/reduction/frame.hpp"
#include "host/config/shot_plan.hpp"
#include "host/session/event_ledger.hpp"

namespace strobe::host {

class CommandMaker {
 public:
  /// host_id: random, not 0.
  explicit CommandMaker(std::int64_t host_id) : host_id_(host_id) {}

  std::int64_t host_id() const { return host_id_; }
  strobe_msgs::command_t arm(std::int64_t boot_id);
  strobe_msgs::command_t fire(std::int64_t boot_id, std::int64_t arm_token, const ShotPlan& plan, bool dry,
                              const reduction::Record& notes);
  strobe_msgs::command_t disarm(std::int64_t boot_id);
  strobe_msgs::command_t clear(std::int64_t boot_id);
  strobe_msgs::command_t resend(const SequenceRange& range);

 private:
  strobe_msgs::command_t make(std::int64_t boot_id, std::int8_t kind);

  std::int64_t host_id_;
  std::int64_t next_id_ = 1;
};

strobe_msgs::plan_t plan_message(const ShotPlan& plan, bool dry);

}  // namespace strobe::host
