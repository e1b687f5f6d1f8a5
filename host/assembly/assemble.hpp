// From a shot of the firmware and its digitized photograph to a frame with times, and on to the readout.
// Deterministic, no I/O; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/matching/track.hpp"
#include "common/reduction/mixture.hpp"
#include "common/reduction/readout.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/assembly/flash_times.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::host {

/// The rig's part of the assembly's input.
struct AssemblySettings {
  BallSettings ball;
  AnalysisSettings analysis;
  std::optional<double> machine_lag_s;
  CameraTable camera;    ///< for the map's errors
  bool budgets = false;  ///< give ShotReadout::matched
};

AssemblySettings assembly_settings(const RigFile& rig);

/// How long a ball of this kind may touch the surface.
matching::DwellLimits contact_of(const BallSettings& ball);

struct AssembledShot {
  /// images with the times of their flashes, from the first image's; empty if unmatched
  reduction::Frame frame;
  reduction::FlagSet flags;  ///< of the flashes that show the ball, the match, the sensors and the shot
  /// Plausible assignments, the frame's first; empty if unmatched.
  std::vector<reduction::AssignedTimes> hypotheses;
  std::optional<reduction::ImagedFlashes> flashes;  ///< absent if unmatched
  FlashTimes times;                                 ///< of all flashes of the shot
  std::string problem;  ///< why the frame could not be matched, for a person; else empty
};

/// Never throws for what a message can hold.
AssembledShot assemble(const strobe_msgs::shot_t& shot, const strobe_msgs::frame_t& frame,
                       const AssemblySettings& settings);

/// The shot's notes as a record.
reduction::Record record_of(const strobe_msgs::shot_t& shot);

/// A readout without numbers: the shot's id and record, method "best" and these flags.
reduction::Readout empty_readout(const strobe_msgs::shot_t& shot, const reduction::FlagSet& flags);

struct ShotReadout {
  reduction::Readout readout;
  std::string problem;  ///< for a person; empty if the flags say all
  FlashTimes times;     ///< of all flashes of the shot
  std::optional<reduction::Frame>
      matched{};  ///< what was reduced, if budgets are asked for: for reduction::mixture_budget()
};

/// Assembles and reduces with the best estimator, to the mixture over the plausible assignments of flashes to
/// images (common/reduction/mixture.hpp). A frame that cannot be reduced gives a readout without numbers.
ShotReadout shot_readout(const strobe_msgs::shot_t& shot, const strobe_msgs::frame_t& frame,
                         const AssemblySettings& settings);

/// Flags of the shot itself, whatever the photograph shows: aborted, events lost before the journal, missing
/// or late feedback of the shutter.
reduction::FlagSet shot_flags(const strobe_msgs::shot_t& shot);

}  // namespace strobe::host
