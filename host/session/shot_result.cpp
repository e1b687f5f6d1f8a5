#include "host/session/shot_result.hpp"

#include <utility>

#include "host/session/rejection.hpp"

namespace strobe::host {
namespace {

using reduction::Flag;
using reduction::FlagSet;
using strobe_msgs::shot_t;

ShotResult of(const shot_t& shot) {
  ShotResult result;
  result.boot_id = shot.boot_id;
  result.host_id = shot.host_id;
  result.shot_id = shot.shot_id;
  result.dry = shot.plan.dry;
  result.train = train_report(shot);
  return result;
}

}  // namespace

ShotResult measured_result(const shot_t& shot, const strobe_msgs::frame_t& frame, const FlagSet& more,
                           const AssemblySettings& settings) {
  ShotReadout measured = shot_readout(shot, frame, settings);
  ShotResult result = of(shot);
  measured.readout.flags.merge(more);
  result.rejected = rejection_reason(measured.readout,
                                     {settings.analysis.match_tolerance_percent, settings.ball.diameter_m},
                                     result.train.faults);
  result.readout = std::move(measured.readout);
  result.assembled = std::move(measured.assembled);
  result.problem = shot.aborted ? shot.abort_reason : std::move(measured.problem);
  result.frame = frame;
  return result;
}

ShotResult unmeasured_result(const shot_t& shot, const FlagSet& more, std::string problem) {
  ShotResult result = of(shot);
  FlagSet flags = shot_flags(shot);
  flags.merge(more);
  result.readout = empty_readout(shot, flags);
  result.rejected = rejection_reason(result.readout);
  result.problem = std::move(problem);
  return result;
}

ShotResult dry_result(const shot_t& shot) {
  ShotResult result = of(shot);
  result.readout = empty_readout(shot, shot_flags(shot));
  result.problem = shot.abort_reason;
  if (shot.aborted) result.rejected = std::string(words(Flag::shot_aborted));
  return result;
}

ShotResult interrupted_result(const ShotKey& key, std::int64_t host_id, bool dry, std::string why) {
  shot_t shot{};
  shot.boot_id = key.boot_id;
  shot.shot_id = key.shot_id;
  shot.host_id = host_id;
  shot.plan.dry = dry;
  shot.aborted = true;
  shot.abort_reason = std::move(why);
  FlagSet flags;
  flags.set(Flag::events_missing);
  return unmeasured_result(shot, flags, shot.abort_reason);
}

}  // namespace strobe::host
