// What becomes of a shot: its readout, or why it has none. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>

#include "common/reduction/uncertainty.hpp"
#include "common/reduction/readout.hpp"
#include "common/shot/shot_key.hpp"
#include "host/assembly/assemble.hpp"
#include "host/session/train_report.hpp"

namespace strobe::host {

/// One shot, done with.
struct ShotResult {
  std::int64_t boot_id = 0;
  std::int64_t host_id = 0;  ///< who fired it
  int shot_id = 0;
  bool dry = false;
  reduction::Readout readout;  ///< without numbers for a dry shot
  TrainReport train;
  std::optional<std::string> rejected;        ///< why it does not count; nothing: it counts
  std::string problem;                        ///< more words for a person; may be empty
  bool verified = true;                       ///< false: nothing proves that its messages are the lab's
  std::optional<strobe_msgs::frame_t> frame;  ///< of the photograph that the readout comes from
  std::optional<AssembledShot> assembled;     ///< if AssemblySettings asks for budgets: what one is made from
  std::optional<reduction::Budget> budget;    ///< made by the loop once the readout has been published
};

/// Of a shot with its photograph. more: flags that shot and photograph do not tell.
ShotResult measured_result(const strobe_msgs::shot_t& shot, const strobe_msgs::frame_t& frame,
                           const reduction::FlagSet& more, const AssemblySettings& settings);

/// Of a shot without; more: flags, among them why. problem: for a person.
ShotResult unmeasured_result(const strobe_msgs::shot_t& shot, const reduction::FlagSet& more,
                             std::string problem);

ShotResult dry_result(const strobe_msgs::shot_t& shot);

/// Of a shot that has no summary. host_id: who fired it. why: for a person.
ShotResult interrupted_result(const ShotKey& key, std::int64_t host_id, bool dry, std::string why);

}  // namespace strobe::host
