#include "host/archive/reduce_again.hpp"

#include "host/assembly/assemble.hpp"

namespace strobe::host {

Result<ShotResult> reduced_by(const StoredShot& shot, reduction::Estimator estimator,
                              const reduction::ReduceOptions& options) {
  const std::string which = "shot " + shot.name;
  if (!shot.summary || shot.digitizations.empty())
    return fail(which + " has no photograph that was digitized");
  const AssembledShot assembled =
      assemble(*shot.summary, shot.digitizations.back().frame, assembly_settings(*shot.rig));
  if (!assembled.problem.empty()) return fail(which + ": " + assembled.problem);
  auto readout = reduction::reduce(assembled.frame, estimator, options);
  if (!readout) return fail(which + ": " + readout.error().message);
  readout->flags.merge(assembled.flags);
  readout->flashes = assembled.flashes;
  ShotResult result = shot.result;
  result.readout = std::move(*readout);
  return result;
}

}  // namespace strobe::host
