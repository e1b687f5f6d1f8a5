#include "host/archive/shot_outcome.hpp"

#include <fmt/format.h>

namespace strobe::host {

using reduction::Flag;

ShotResult logged_outcome(const ShotKey& key, const FiredShot& fired) {
  if (fired.result) return *fired.result;
  if (!fired.summary)
    return interrupted_result(key, fired.host_id, fired.dry,
                              "its end is in no log: the host, or the firmware, ended in it");
  reduction::FlagSet flags;
  flags.set(Flag::no_photograph);
  return unmeasured_result(*fired.summary, flags, "no photograph in the log");
}

/// What another photograph cannot change.
static reduction::FlagSet lasting_flags(const StoredShot& shot) {
  reduction::FlagSet flags;
  for (const Flag flag : {Flag::events_missing, Flag::clock_suspect})
    if (shot.result.readout.flags.has(flag)) flags.set(flag);
  return flags;
}

ShotResult measured_again(const StoredShot& shot, const strobe_msgs::frame_t& frame) {
  ShotResult result =
      measured_result(*shot.summary, frame, lasting_flags(shot), assembly_settings(*shot.rig));
  result.verified = shot.result.verified;
  return result;
}

ShotResult without_photograph(const StoredShot& shot) {
  if (!shot.summary) return shot.result;
  reduction::FlagSet flags = lasting_flags(shot);
  flags.set(Flag::no_photograph);
  ShotResult result = unmeasured_result(*shot.summary, flags, "no photograph in the log");
  result.verified = shot.result.verified;
  return result;
}

bool never_digitized(const StoredShot& shot) {
  return shot.summary && shot.photograph && shot.digitizations.empty();
}

std::optional<std::string> never_digitized_remark(const StoredSession& session) {
  std::vector<std::string> names;
  for (const StoredShot& shot : session.shots)
    if (never_digitized(shot) && !shot.summary->aborted) names.push_back(shot.name);
  if (names.empty()) return std::nullopt;
  return fmt::format("the photograph{} of shot{} {} {} never digitized; strobe replay {} --complete does it",
                     names.size() == 1 ? "" : "s", names.size() == 1 ? "" : "s", fmt::join(names, ", "),
                     names.size() == 1 ? "was" : "were", session.folder.string());
}

}  // namespace strobe::host
